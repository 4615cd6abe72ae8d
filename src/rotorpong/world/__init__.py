"""The simulator: court, serves, contact, rendering, sensors, and the drone they make together."""
