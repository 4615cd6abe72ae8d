"""The store: demonstrations, trials and runs that outlive the process, one file each run."""

from rotorpong.experience.records import Attempt, Demonstration, Run, Trial
from rotorpong.experience.shipped import shipped_demonstrations
from rotorpong.experience.store import Store, create, open_store

__all__ = [
    "Attempt",
    "Demonstration",
    "Run",
    "Store",
    "Trial",
    "create",
    "open_store",
    "shipped_demonstrations",
]
