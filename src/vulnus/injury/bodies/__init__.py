"""What meets what: shapes, solids of tissue, rigid bodies, and the table of projectiles."""
