"""Follows one sign through a video; the proposals become data only when a person accepts them."""
