"""What the rest of the package uses: checks, files written whole, pictures, words of the screen."""
