"""Composition: a frozen spec becomes world, eyes and player, is played, and is kept."""
