# Raspberry Pi Pico 2.
set(PICO_BOARD pico2)
set(TORSIO_CHIP rp2350)
