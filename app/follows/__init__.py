"""Following one sign through a video: proposals that belong to nobody until a person accepts them."""
