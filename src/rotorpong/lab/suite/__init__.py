"""The frozen benchmark: the same balls for every player and every version, for leaderboards."""
