"""Files that several servers of one database share: a folder that all of them mount, or a bucket of S3."""
