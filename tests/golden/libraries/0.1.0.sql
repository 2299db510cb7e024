BEGIN TRANSACTION;
CREATE TABLE alembic_version (
	version_num VARCHAR(32) NOT NULL, 
	CONSTRAINT alembic_version_pkc PRIMARY KEY (version_num)
);
INSERT INTO "alembic_version" VALUES('0006');
CREATE TABLE artefacts (
	id VARCHAR(32) NOT NULL, 
	kind VARCHAR(16) NOT NULL, 
	run_id VARCHAR(32), 
	name TEXT NOT NULL, 
	state VARCHAR(16) NOT NULL, 
	error TEXT, 
	options JSON NOT NULL, 
	done INTEGER NOT NULL, 
	total INTEGER, 
	path TEXT NOT NULL, 
	size BIGINT, 
	sha256 VARCHAR(64) NOT NULL, 
	summary JSON NOT NULL, 
	created DATETIME NOT NULL, 
	finished DATETIME, place VARCHAR(32), 
	PRIMARY KEY (id), 
	FOREIGN KEY(run_id) REFERENCES runs (id) ON DELETE SET NULL
);
CREATE TABLE edits (
	seq INTEGER NOT NULL, 
	op_id VARCHAR(64) NOT NULL, 
	run_id VARCHAR(32) NOT NULL, 
	author TEXT NOT NULL, 
	kind VARCHAR(32) NOT NULL, 
	command JSON NOT NULL, 
	frame INTEGER, 
	"before" JSON NOT NULL, 
	"after" JSON NOT NULL, 
	reverts VARCHAR(64), 
	created DATETIME NOT NULL, 
	PRIMARY KEY (seq), 
	FOREIGN KEY(run_id) REFERENCES runs (id) ON DELETE CASCADE, 
	UNIQUE (op_id)
);
INSERT INTO "edits" VALUES(1,'operation-1','aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa','ada','relabel_track','{"frame": 0, "key": "m1", "spans": [], "name": "relabel_track", "class_id": 13}',0,'{"m1": {"key": "m1", "revision": 0, "class_id": null, "review": "open", "not_a_sign": false, "segments": [{"track": 1, "first": 0, "last": 20}], "keys": {}, "notes": [], "gone": false, "merged_into": null}}','{"m1": {"key": "m1", "revision": 1, "class_id": 13, "review": "open", "not_a_sign": false, "segments": [{"track": 1, "first": 0, "last": 20}], "keys": {}, "notes": [], "gone": false, "merged_into": null}}',NULL,'2026-11-26 03:09:18.374670');
INSERT INTO "edits" VALUES(2,'operation-2','aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa','ada','relabel_box','{"frame": 5, "key": "m1", "spans": [], "name": "relabel_box", "class_id": 42, "box": [1.0, 2.0, 3.0, 4.0]}',5,'{"m1": {"key": "m1", "revision": 1, "class_id": 13, "review": "open", "not_a_sign": false, "segments": [{"track": 1, "first": 0, "last": 20}], "keys": {}, "notes": [], "gone": false, "merged_into": null}}','{"m1": {"key": "m1", "revision": 2, "class_id": 13, "review": "open", "not_a_sign": false, "segments": [{"track": 1, "first": 0, "last": 20}], "keys": {"5": {"box": [1.0, 2.0, 3.0, 4.0], "occluded": false, "outside": false, "interpolate": false, "class_id": 42, "followed": false}}, "notes": [], "gone": false, "merged_into": null}}',NULL,'2026-11-26 03:09:18.380990');
INSERT INTO "edits" VALUES(3,'operation-3','aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa','ada','relabel_track','{"frame": 16, "key": "m2", "spans": [], "name": "relabel_track", "class_id": -1}',16,'{"m2": {"key": "m2", "revision": 0, "class_id": null, "review": "open", "not_a_sign": false, "segments": [{"track": 2, "first": 15, "last": 40}], "keys": {}, "notes": [], "gone": false, "merged_into": null}}','{"m2": {"key": "m2", "revision": 1, "class_id": -1, "review": "open", "not_a_sign": false, "segments": [{"track": 2, "first": 15, "last": 40}], "keys": {}, "notes": [], "gone": false, "merged_into": null}}',NULL,'2026-11-26 03:09:18.388776');
INSERT INTO "edits" VALUES(4,'operation-4','aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa','ada','create_track','{"frame": 9, "key": "habcdef", "spans": [], "name": "create_track", "box": [10.0, 20.0, 30.0, 40.0], "class_id": 0}',9,'{"habcdef": null}','{"habcdef": {"key": "habcdef", "revision": 1, "class_id": 0, "review": "open", "not_a_sign": false, "segments": [], "keys": {"9": {"box": [10.0, 20.0, 30.0, 40.0], "occluded": false, "outside": false, "interpolate": true, "class_id": null, "followed": false}}, "notes": [], "gone": false, "merged_into": null}}',NULL,'2026-11-26 03:09:18.400846');
INSERT INTO "edits" VALUES(5,'operation-5','aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa','ada','merge','{"frame": 16, "key": "m2", "spans": [], "name": "merge", "others": ["m3"]}',16,'{"m2": {"key": "m2", "revision": 1, "class_id": -1, "review": "open", "not_a_sign": false, "segments": [{"track": 2, "first": 15, "last": 40}], "keys": {}, "notes": [], "gone": false, "merged_into": null}, "m3": {"key": "m3", "revision": 0, "class_id": null, "review": "open", "not_a_sign": false, "segments": [{"track": 3, "first": 50, "last": 70}], "keys": {}, "notes": [], "gone": false, "merged_into": null}}','{"m2": {"key": "m2", "revision": 2, "class_id": -1, "review": "open", "not_a_sign": false, "segments": [{"track": 2, "first": 15, "last": 40}, {"track": 3, "first": 50, "last": 70}], "keys": {}, "notes": [], "gone": false, "merged_into": null}, "m3": {"key": "m3", "revision": 1, "class_id": null, "review": "open", "not_a_sign": false, "segments": [{"track": 3, "first": 50, "last": 70}], "keys": {}, "notes": [], "gone": true, "merged_into": "m2"}}',NULL,'2026-11-26 03:09:18.406372');
CREATE TABLE events (
	seq INTEGER NOT NULL, 
	kind VARCHAR(32) NOT NULL, 
	subject VARCHAR(64) NOT NULL, 
	data JSON NOT NULL, 
	time DATETIME NOT NULL, 
	PRIMARY KEY (seq)
);
INSERT INTO "events" VALUES(1,'edit','aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa','{"seq": 1, "op_id": "operation-1", "author": "ada", "docs": [{"key": "m1", "revision": 1, "class_id": 13, "review": "open", "not_a_sign": false, "segments": [{"track": 1, "first": 0, "last": 20}], "keys": {}, "notes": [], "gone": false, "merged_into": null}]}','2026-11-26 03:09:18.376266');
INSERT INTO "events" VALUES(2,'edit','aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa','{"seq": 2, "op_id": "operation-2", "author": "ada", "docs": [{"key": "m1", "revision": 2, "class_id": 13, "review": "open", "not_a_sign": false, "segments": [{"track": 1, "first": 0, "last": 20}], "keys": {"5": {"box": [1.0, 2.0, 3.0, 4.0], "occluded": false, "outside": false, "interpolate": false, "class_id": 42, "followed": false}}, "notes": [], "gone": false, "merged_into": null}]}','2026-11-26 03:09:18.381851');
INSERT INTO "events" VALUES(3,'edit','aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa','{"seq": 3, "op_id": "operation-3", "author": "ada", "docs": [{"key": "m2", "revision": 1, "class_id": -1, "review": "open", "not_a_sign": false, "segments": [{"track": 2, "first": 15, "last": 40}], "keys": {}, "notes": [], "gone": false, "merged_into": null}]}','2026-11-26 03:09:18.389186');
INSERT INTO "events" VALUES(4,'edit','aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa','{"seq": 4, "op_id": "operation-4", "author": "ada", "docs": [{"key": "habcdef", "revision": 1, "class_id": 0, "review": "open", "not_a_sign": false, "segments": [], "keys": {"9": {"box": [10.0, 20.0, 30.0, 40.0], "occluded": false, "outside": false, "interpolate": true, "class_id": null, "followed": false}}, "notes": [], "gone": false, "merged_into": null}]}','2026-11-26 03:09:18.401255');
INSERT INTO "events" VALUES(5,'edit','aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa','{"seq": 5, "op_id": "operation-5", "author": "ada", "docs": [{"key": "m2", "revision": 2, "class_id": -1, "review": "open", "not_a_sign": false, "segments": [{"track": 2, "first": 15, "last": 40}, {"track": 3, "first": 50, "last": 70}], "keys": {}, "notes": [], "gone": false, "merged_into": null}, {"key": "m3", "revision": 1, "class_id": null, "review": "open", "not_a_sign": false, "segments": [{"track": 3, "first": 50, "last": 70}], "keys": {}, "notes": [], "gone": true, "merged_into": "m2"}]}','2026-11-26 03:09:18.406982');
CREATE TABLE follow_pieces (
	follow_id VARCHAR(32) NOT NULL, 
	number INTEGER NOT NULL, 
	proposals JSON NOT NULL, 
	PRIMARY KEY (follow_id, number), 
	FOREIGN KEY(follow_id) REFERENCES follows (id) ON DELETE CASCADE
);
CREATE TABLE follows (
	id VARCHAR(32) NOT NULL, 
	run_id VARCHAR(32) NOT NULL, 
	author TEXT NOT NULL, 
	"key" VARCHAR(64) NOT NULL, 
	request JSON NOT NULL, 
	state VARCHAR(16) NOT NULL, 
	error TEXT, 
	endings JSON NOT NULL, 
	pieces INTEGER NOT NULL, 
	asked DATETIME NOT NULL, 
	PRIMARY KEY (id), 
	FOREIGN KEY(run_id) REFERENCES runs (id) ON DELETE CASCADE
);
CREATE TABLE jobs (
	id VARCHAR(32) NOT NULL, 
	kind VARCHAR(32) NOT NULL, 
	subject VARCHAR(64) NOT NULL, 
	payload JSON NOT NULL, 
	state VARCHAR(16) NOT NULL, 
	priority INTEGER NOT NULL, 
	token INTEGER NOT NULL, 
	crashes INTEGER NOT NULL, 
	position INTEGER, 
	cancel BOOLEAN NOT NULL, 
	heartbeat DATETIME, 
	error TEXT, 
	"order" BIGINT NOT NULL, 
	created DATETIME NOT NULL, 
	started DATETIME, 
	finished DATETIME, place VARCHAR(32), 
	PRIMARY KEY (id)
);
CREATE TABLE model_versions (
	id VARCHAR(32) NOT NULL, 
	name TEXT NOT NULL, 
	state VARCHAR(16) NOT NULL, 
	error TEXT, 
	parent_id VARCHAR(32), 
	folder TEXT NOT NULL, 
	lineage JSON NOT NULL, 
	figures JSON NOT NULL, 
	models JSON NOT NULL, 
	stage TEXT NOT NULL, 
	done INTEGER NOT NULL, 
	total INTEGER, 
	promoted INTEGER NOT NULL, 
	created DATETIME NOT NULL, 
	finished DATETIME, place VARCHAR(32), 
	PRIMARY KEY (id)
);
CREATE TABLE runs (
	id VARCHAR(32) NOT NULL, 
	video_id VARCHAR(64) NOT NULL, 
	kind VARCHAR(16) NOT NULL, 
	name TEXT NOT NULL, 
	parent_id VARCHAR(32), 
	state VARCHAR(16) NOT NULL, 
	error TEXT, 
	preset VARCHAR(32) NOT NULL, 
	parameters JSON NOT NULL, 
	first INTEGER NOT NULL, 
	stop INTEGER, 
	folder TEXT NOT NULL, 
	engine_version VARCHAR(32) NOT NULL, 
	models JSON NOT NULL, 
	frames_done INTEGER NOT NULL, 
	frames_total INTEGER, 
	rate FLOAT, 
	tracks INTEGER, 
	summary JSON NOT NULL, 
	created DATETIME NOT NULL, 
	started DATETIME, 
	finished DATETIME, "order" BIGINT DEFAULT '0' NOT NULL, place VARCHAR(32), 
	PRIMARY KEY (id), 
	FOREIGN KEY(parent_id) REFERENCES runs (id) ON DELETE CASCADE, 
	FOREIGN KEY(video_id) REFERENCES videos (id) ON DELETE CASCADE
);
INSERT INTO "runs" VALUES('aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa','ffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffff','engine','',NULL,'complete',NULL,'default','{}',0,NULL,'','','{}',0,NULL,NULL,NULL,'{}','2026-11-26 03:09:18.354520',NULL,NULL,1,NULL);
CREATE TABLE servers (
	id VARCHAR(32) NOT NULL, 
	name TEXT NOT NULL, 
	beats BIGINT NOT NULL, 
	PRIMARY KEY (id)
);
CREATE TABLE track_documents (
	run_id VARCHAR(32) NOT NULL, 
	"key" VARCHAR(64) NOT NULL, 
	revision INTEGER NOT NULL, 
	document JSON NOT NULL, 
	PRIMARY KEY (run_id, "key"), 
	FOREIGN KEY(run_id) REFERENCES runs (id) ON DELETE CASCADE
);
INSERT INTO "track_documents" VALUES('aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa','m1',2,'{"key": "m1", "revision": 2, "class_id": 13, "review": "open", "not_a_sign": false, "segments": [{"track": 1, "first": 0, "last": 20}], "keys": {"5": {"box": [1.0, 2.0, 3.0, 4.0], "occluded": false, "outside": false, "interpolate": false, "class_id": 42, "followed": false}}, "notes": [], "gone": false, "merged_into": null}');
INSERT INTO "track_documents" VALUES('aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa','m2',2,'{"key": "m2", "revision": 2, "class_id": -1, "review": "open", "not_a_sign": false, "segments": [{"track": 2, "first": 15, "last": 40}, {"track": 3, "first": 50, "last": 70}], "keys": {}, "notes": [], "gone": false, "merged_into": null}');
INSERT INTO "track_documents" VALUES('aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa','habcdef',1,'{"key": "habcdef", "revision": 1, "class_id": 0, "review": "open", "not_a_sign": false, "segments": [], "keys": {"9": {"box": [10.0, 20.0, 30.0, 40.0], "occluded": false, "outside": false, "interpolate": true, "class_id": null, "followed": false}}, "notes": [], "gone": false, "merged_into": null}');
INSERT INTO "track_documents" VALUES('aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa','m3',1,'{"key": "m3", "revision": 1, "class_id": null, "review": "open", "not_a_sign": false, "segments": [{"track": 3, "first": 50, "last": 70}], "keys": {}, "notes": [], "gone": true, "merged_into": "m2"}');
CREATE TABLE truths (
	id VARCHAR(32) NOT NULL, 
	video_id VARCHAR(64) NOT NULL, 
	name TEXT NOT NULL, 
	boxes BLOB NOT NULL, 
	count INTEGER NOT NULL, 
	created DATETIME NOT NULL, 
	PRIMARY KEY (id), 
	FOREIGN KEY(video_id) REFERENCES videos (id) ON DELETE CASCADE
);
INSERT INTO "truths" VALUES('dffcee989f8c4a40842d94481e349fc8','ffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffff','drawn',X'789C636040061FEC21B48A03843681D27650DA054AEB38A0AA676000009B5204A5',1,'2026-11-26 03:09:18.416383');
CREATE TABLE videos (
	id VARCHAR(64) NOT NULL, 
	name TEXT NOT NULL, 
	path TEXT NOT NULL, 
	size BIGINT NOT NULL, 
	state VARCHAR(16) NOT NULL, 
	error TEXT, 
	owned BOOLEAN NOT NULL, 
	sample BOOLEAN NOT NULL, 
	width INTEGER, 
	height INTEGER, 
	rotation INTEGER, 
	codec VARCHAR(32), 
	rate FLOAT, 
	frames INTEGER, 
	duration FLOAT, 
	warnings JSON NOT NULL, 
	frame_table BLOB, 
	created DATETIME NOT NULL, place VARCHAR(32), stamp JSON, pixel_ratio FLOAT DEFAULT '1' NOT NULL, 
	PRIMARY KEY (id)
);
INSERT INTO "videos" VALUES('ffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffff','drive.mp4','/drives/drive.mp4',1,'ready',NULL,0,0,NULL,NULL,NULL,NULL,NULL,75,NULL,'[]',NULL,'2026-11-26 03:09:18.345492',NULL,NULL,1.0);
CREATE INDEX ix_jobs_order ON jobs ("order");
CREATE INDEX ix_jobs_state ON jobs (state);
CREATE INDEX ix_jobs_subject ON jobs (subject);
CREATE INDEX ix_runs_video_id ON runs (video_id);
CREATE INDEX ix_truths_video_id ON truths (video_id);
CREATE INDEX edits_of_run ON edits (run_id, seq);
CREATE INDEX edits_of_author ON edits (run_id, author, seq);
CREATE INDEX ix_artefacts_kind ON artefacts (kind);
CREATE INDEX ix_artefacts_run_id ON artefacts (run_id);
CREATE INDEX ix_runs_order ON runs ("order");
CREATE INDEX ix_follows_run_id ON follows (run_id);
COMMIT;
