"""People of a team: accounts and roles, the caller, assignments, and activity."""
