"""MuJoCo as the plant: robots with contacts, friction and castors behind the same laws, sensors and loop."""
