"""The command line, the doctor, and what pytest loads."""
