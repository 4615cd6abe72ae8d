"""How ball, bounce, vehicle and camera behave: equations only, no world, no state."""
