"""Follows signs from one drawn box: with our follower, with peers, and with straight lines."""
