"""Floor 3: the C core, the tables that it reads, and their compiler."""
