"""People of a team: accounts and roles, who is asking, who works on what, and what was done."""
