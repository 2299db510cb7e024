"""What would change with other parameters: a replay of stored evidence."""
