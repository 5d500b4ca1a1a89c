"""A skyline's carriage: load path, payload, pretension, supports, inhaul."""
