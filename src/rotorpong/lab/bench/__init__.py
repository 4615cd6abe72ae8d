"""Our own benchmark rows: what `rotorpong bench` prints, each beside its target and its peer."""
