# Raspberry Pi Pico.
set(PICO_BOARD pico)
set(TORSIO_CHIP rp2040)
# The RP2040's highest rated clock, with the core voltage that belongs to it: floating point in
# software needs the time.
set(TORSIO_BOARD_DEFINITIONS SYS_CLK_MHZ=200)
