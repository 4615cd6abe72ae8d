"""`python -m rotorpong`."""

from rotorpong.cli import main

if __name__ == "__main__":
    main()
