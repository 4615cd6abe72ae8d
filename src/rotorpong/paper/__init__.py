"""The paper's evaluation, one file per table or figure, each number beside the paper's."""

from rotorpong.paper.reproduce import ITEMS, reproduce

__all__ = ["ITEMS", "reproduce"]
