"""Players: see, estimate, choose, hit, learn. They never reach the simulator."""
