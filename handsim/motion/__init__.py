"""What people did: recordings of hand postures, their files and their phases."""
