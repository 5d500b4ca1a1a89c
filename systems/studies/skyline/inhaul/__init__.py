"""A skyline rig in time: the carriage pulled along by the mainline's drum."""
