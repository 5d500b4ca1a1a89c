"""A skyline rig over time: the mainline's drum pulls the carriage."""
