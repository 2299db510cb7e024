"""Signs of GTSDB's training scenes that ``gt.txt`` does not name: how they were found, named and measured."""
