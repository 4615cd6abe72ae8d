"""The command line: arguments -> calls."""

from rotorpong.cli.entry import main as main
