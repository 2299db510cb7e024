// @ts-check
/**
 * The shapes that travel between server, store and views. Types only: this module has no code.
 *
 * A box is `[x1, y1, x2, y2]`, 0-based pixel edges of the upright picture. A frame is its ordinal.
 */

/** @typedef {[number, number, number, number]} Box */

// ------------------------------------------------------------------------------------------------ from the server

/** @typedef {{error: {code: string, message: string, field?: string|null, details?: Record<string, unknown>}}} ApiError */

/**
 * @typedef {object} Session
 * @property {string} version
 * @property {string} author           name that edits carry unless the page sets another
 * @property {string[]} roots          folders that videos may be added from
 * @property {number} upload_bytes     largest upload
 * @property {{video_id: string, run_id: string|null}|null} sample  the bundled drive
 * @property {string[]} presets
 */

/**
 * A question about a sign beside its label.
 * @typedef {object} Attribute
 * @property {string} name
 * @property {'checkbox'|'select'|'number'|'text'} kind
 * @property {boolean} mutable         the answer may change from frame to frame
 * @property {string[]} values         answers of a select
 * @property {number|null} low
 * @property {number|null} high
 * @property {boolean|number|string|null} default
 */

/**
 * @typedef {object} Label
 * @property {number} id
 * @property {string} key
 * @property {string} name
 * @property {string} short            empty: the beginning of the name
 * @property {string[]} aliases
 * @property {string|null} picture     address of the pictogram; null: it has none
 * @property {string} shape
 * @property {string} category
 * @property {Attribute[]} attributes
 * @property {number|null} size_mm
 * @property {string|null} mirror      key of the label that its mirror image is
 * @property {'sign'|'background'|'ignore'} teach   what a retraining makes of it
 * @property {string|null} colour      `#rrggbb`
 * @property {number|null} pinned      1 to 9
 * @property {boolean} hidden          not offered any more
 * @property {number|null} merged_into id of the label that stands for it
 */

/** @typedef {{key: string, name: string, version: number, labels: number, default: boolean, shipped: boolean}} LabelSetHead   `labels`: how many */
/** @typedef {{version: number, author: string, created: string|null, sentence: string, undoes: number|null}} LabelVersion   `created`: null: as it came with tsr */
/** @typedef {{type: 'add'|'update'|'merge'|'hide'|'show'|'picture'|'undo'|'adopt', [field: string]: unknown}} LabelChange   see docs/labels.md */
/** @typedef {{name: string, tracks: number, boxes: number, suggestions: {id: number, key: string, name: string}[], example: {frame: number, box: Box}|null}} UnknownLabel   a name in a file that no label has */

/**
 * @typedef {object} Parameter
 * @property {string} section
 * @property {string} name
 * @property {'number'|'integer'|'boolean'|'choice'|'text'} type
 * @property {unknown} default
 * @property {number|null} low
 * @property {number|null} high
 * @property {string[]|null} choices
 * @property {string} description
 * @property {boolean} replayable      a what-if may change it
 * @property {Record<string, unknown>} presets   preset -> value where it departs
 */

/**
 * @typedef {object} Video
 * @property {string} id               SHA-256
 * @property {string} name
 * @property {string} path
 * @property {number} size             bytes
 * @property {'importing'|'ready'|'failed'} state
 * @property {string|null} error
 * @property {boolean} missing         the file is not there (any more)
 * @property {boolean} sample
 * @property {number|null} width
 * @property {number|null} height
 * @property {number} pixel_ratio      width of a pixel by its height: pictures are shown so, boxes are in stored pixels
 * @property {number|null} frames
 * @property {number|null} duration    s
 * @property {number|null} rate
 * @property {string|null} codec
 * @property {string[]} warnings
 * @property {string|null} [label_set] key of its label set; null: the library's
 * @property {string[]} [tags]         words that people have given it
 * @property {string} created          ISO 8601
 * @property {number} runs             number of runs
 * @property {string|null} latest_run
 * @property {{tracks: number, reviewed: number}} review   of the latest complete run: tracks that are there, and those accepted or rejected
 */

/**
 * A track that the search has found.
 * @typedef {object} FoundTrack
 * @property {string} run
 * @property {string} run_name
 * @property {string} video
 * @property {string} video_name
 * @property {string[]} tags           of the video
 * @property {string} key
 * @property {{set: string, id: number, name: string}|null} label   null: none of the set's labels
 * @property {'open'|'needs_work'|'accepted'|'rejected'|'ignored'} state
 * @property {number} uncertainty      0..1
 * @property {number} size             longer side of its largest box, px
 * @property {number} frame            where that box is
 * @property {Box} box
 * @property {number} first
 * @property {number} last
 * @property {number} revision
 * @property {string|null} author      who edited it last
 * @property {string|null} edited
 * @property {boolean} notes           whether there are any
 */

/**
 * @typedef {object} FrameTableData
 * @property {number} frames
 * @property {[number, number]} time_base      numerator, denominator: pts * n / d = seconds
 * @property {number} first_pts
 * @property {[number, number][]} steps        runs of equal pts steps: [step, how often]
 * @property {number[]} keys                   ordinals of key frames
 * @property {number[]} corrupt                ordinals of damaged frames
 */

/**
 * @typedef {object} Run
 * @property {string} id
 * @property {string} video_id
 * @property {'engine'|'whatif'|'imported'} kind
 * @property {string} name
 * @property {string|null} parent_id
 * @property {'queued'|'running'|'complete'|'failed'|'cancelled'|'interrupted'} state
 * @property {string|null} error
 * @property {string} preset
 * @property {Record<string, unknown>} parameters   what differs from the preset
 * @property {number} first
 * @property {number|null} stop
 * @property {number} frames_done
 * @property {number|null} frames_total
 * @property {number|null} rate               frames a second
 * @property {number|null} remaining          s
 * @property {number|null} tracks             confirmed tracks
 * @property {string} engine_version
 * @property {Record<string, string>} models
 * @property {Record<string, any>} summary        of a complete run; `focus`: its camera's focus of expansion, null or {x, y: shares of the picture, named: by a person}; of a what-if: `identical_frames`, `missing_pixels` in
 *   `missing_frames` that the evidence lacks, `difference`
 * @property {string} created
 * @property {string|null} finished
 */

/** @typedef {{run_id: string, tracks: number, seq: number}} Earlier   an earlier run with corrections: tracks that people corrected there, number of its newest operation */

/**
 * Confirmed tracks of a run, a column a property, one entry a track.
 * @typedef {object} TrackColumns
 * @property {number[]} id
 * @property {number[]} first
 * @property {number[]} last
 * @property {number[]} frames
 * @property {number[]} detected       frames with a detection
 * @property {(Box|null)[]} [first_box]   box in the first frame; servers before 0.2 do not send it
 * @property {(Box|null)[]} [last_box]    and in the last
 * @property {number[]} clearest       frame of the last detection, where a sign that a camera nears is largest
 * @property {(number|null)[]} class_id   label of the video's set; -1: the set lacks what the engine calls it
 * @property {(string|null)[]} [word]   what the engine calls it, where the set lacks that
 * @property {(number|null)[]} share   of the fused class in all votes
 * @property {(number|null)[]} runner_up
 * @property {(string|null)[]} [runner_up_word]
 * @property {(number|null)[]} runner_up_share
 * @property {number[]} score          best final score
 * @property {number[]} side           longest side, px
 * @property {number[]} rejected       frames with a rejected prediction
 * @property {number[]} relocalised
 * @property {number[]} uncertainty          0..1, without what people said
 * @property {number[]} rank           what the queue sorts by: the uncertainty, with what people had said when this was asked for
 * @property {string[][]} reasons      plain sentences why
 * @property {number} tau
 * @property {boolean} complete        false while the run goes on
 */

/**
 * Which source each track's result has over time: runs of equal source, sorted by track then frame.
 * @typedef {object} LaneColumns
 * @property {number[]} track
 * @property {number[]} first
 * @property {number[]} last           inclusive
 * @property {number[]} source         0 detected, 1 predicted, 2 relocalised
 */

/**
 * One track frame by frame, a column a property. `null`: the step did not take place.
 * @typedef {object} TrackLane
 * @property {number} id
 * @property {number[]} frame
 * @property {number[]} source
 * @property {Box[]} box
 * @property {(number|null)[]} score
 * @property {(number|null)[]} raw_score
 * @property {(number|null)[]} prior
 * @property {(number|null)[]} l_positive
 * @property {(number|null)[]} symmetry          1 / max(symmetry_magnitude, symmetry_floor)
 * @property {(number|null)[]} symmetry_magnitude
 * @property {(number|null)[]} hash_distance
 * @property {(number|null)[]} position_distance
 * @property {(boolean|null)[]} confident
 * @property {(number|null)[]} decision          SVM
 * @property {(number|null)[]} probability
 * @property {(number|null)[]} scale             s_t, px
 * @property {(number|null)[]} weight            w_t
 * @property {number[]} classes                  labels that the columns of `votes` and `probabilities` are for (the leading ones); -1: the set lacks it
 * @property {(string|null)[]} [words]           what the engine calls each of them, where the set lacks that
 * @property {(number[]|null)[]} votes           fused share of each of `classes`, 0..1
 * @property {(number[]|null)[]} probabilities   P(c | x_t) of each of `classes`
 * @property {(number|null)[]} top               argmax of P(c | x_t)
 * @property {(string|null)[]} [top_word]        what the engine calls it, where the set lacks that
 * @property {(number|null)[]} top_probability
 * @property {number[]} learned                  samples learned
 * @property {number[]} unlearned
 * @property {{frame: number, kind: string, text: string}[]} events
 * @property {number} tau
 * @property {number} symmetry_floor             the run's parameter: a smaller symmetry_magnitude counts as this in `symmetry`
 */

/**
 * What the layers of one frame show.
 * @typedef {object} Overlay
 * @property {number} frame
 * @property {{box: Box, raw: number, prior: number, score: number, track: number|null}[]} detections
 * @property {OverlayTrack[]} tracks
 */

/**
 * @typedef {object} OverlayTrack
 * @property {number} id
 * @property {'tentative'|'confirmed'} state
 * @property {0|1|2} source
 * @property {Box} box
 * @property {number|null} class_id
 * @property {string|null} [word]      what the engine calls it, where the set lacks that
 * @property {number|null} share
 * @property {{box: Box, sigma: [number, number, number, number]}|null} prediction   sigma of cx, cy, w, h, px
 * @property {{l_positive: number, confident: boolean}|null} gate
 * @property {{search: Box, box: Box, decision: number, probability: number, runner_up: Box, runner_up_decision: number}|null} relocalisation
 */

/**
 * A track as people have left it. Tracks that nobody touched have no document.
 * @typedef {object} TrackDoc
 * @property {string} key              `m7`: the engine's track 7; `h...`: made by a person
 * @property {number} revision         0: untouched
 * @property {number|null} class_id    null: the engine's class stands; -1: none of the classes, as a person says
 * @property {'open'|'accepted'|'rejected'|'needs_work'} review
 * @property {boolean} not_a_sign      as older versions marked a false positive
 * @property {Segment[]} segments      pieces of engine tracks, in order of frames, disjoint
 * @property {Record<string, KeyFrame>} keys   by ordinal
 * @property {Note[]} notes
 * @property {boolean} gone            deleted, or merged into another
 * @property {string|null} merged_into
 * @property {Attributes} [attributes] of the whole track, but for the key frames that have their own; absent: none
 * @property {boolean} [ignore]        a region that nobody counts, and no training learns from
 */

/** @typedef {boolean|number|string} AttributeValue   of a checkbox, of a number, of a select or a text */

/** @typedef {Record<string, AttributeValue>} Attributes   by name */

/** @typedef {{track: number, first: number, last: number}} Segment   `last` is inclusive */

/**
 * @typedef {object} KeyFrame
 * @property {Box|null} box            null: the box is the engine's
 * @property {boolean} occluded        from here to the next key frame
 * @property {boolean} outside         no box from here to the next key frame
 * @property {boolean} interpolate     straight line from here to the next key frame with a box
 * @property {number|null} class_id    of this box only; null: the track's; -1: none of the classes
 * @property {boolean} [followed]      the box was followed from a person's boxes in other frames; following anew may replace it
 * @property {Attributes} [attributes] those that a person has set from here to the next key frame alone; absent: none
 */

/** @typedef {{frame: number, box: Box, anchor: boolean}} FollowedBox   anchor: a person has put it there */

/** @typedef {{id: string, frame: number, text: string, author: string, time: string}} Note */

/**
 * One operation. `name` says which of the others it has; see docs/edits.md.
 * @typedef {object} Command
 * @property {'create_track'|'set_box'|'relabel_track'|'relabel_box'|'merge'|'split'|'delete_from'|'delete_track'|'restore_track'
 *   |'add_key'|'remove_key'|'interpolate'|'follow'|'set_occluded'|'set_outside'|'set_not_a_sign'|'set_review'|'review_tracks'
 *   |'add_note'|'edit_note'|'remove_note'|'ignore'|'attribute'} name
 * @property {number} frame            the frame that the person looks at
 * @property {string} key              the track
 * @property {string[]} [others]       merge: keys that go into `key`; review_tracks: the other tracks
 * @property {string} [new_key]        split: key of the later part
 * @property {Box|null} [box]
 * @property {number|null} [class_id]  split: what the engine says, for a half without a piece of its track
 * @property {FollowedBox[]} [boxes]   follow: in order of frames
 * @property {number} [first]          interpolate
 * @property {number} [last]
 * @property {AttributeValue|null} [value]   attribute: null takes it away
 * @property {string} [attribute]     its name
 * @property {boolean} [from_here]    attribute: from this frame on, not in the whole track
 * @property {'open'|'accepted'|'rejected'|'needs_work'} [review]
 * @property {string} [note_id]
 * @property {string} [text]
 * @property {{track: number, first: number, last: number}[]} [spans]  span of each engine track `m...` among `key` and
 *   `others` that has no document yet
 */

/**
 * @typedef {object} Annotation
 * @property {number} seq              of the newest operation
 * @property {TrackDoc[]} docs
 * @property {UndoTarget|null} undo    what Ctrl+Z would take back for this author
 * @property {UndoTarget|null} redo
 */

/** @typedef {{op_id: string, name: string, frame: number|null, keys: string[]}} UndoTarget */

/** @typedef {Annotation & {op_id: string}} EditAnswer   `docs` holds the touched tracks only */

/** @typedef {{seq: number, kind: string, subject: string, data: any}} ServerEvent */

/** @typedef {{name: string, values: string[], help: string, free: boolean}} Switch   an option of a format; the first value is the default; free: any other text counts as well */

/**
 * @typedef {object} Format
 * @property {string} name
 * @property {string} title
 * @property {string} summary          one sentence
 * @property {boolean} can_export
 * @property {boolean} can_import
 * @property {boolean} needs_pictures
 * @property {boolean} [ignores]    it has a mark for regions to ignore
 * @property {boolean} key_frames   it marks key frames: the bound of thinning matters
 * @property {Switch[]} export_switches
 * @property {Switch[]} import_switches
 * @property {string} docs
 */

/**
 * A file that was made from runs, or is being made.
 * @typedef {object} Output
 * @property {string} id
 * @property {'export'|'recording'|'bundle'|'scene'} kind
 * @property {string|null} run_id
 * @property {string} name             of the file
 * @property {'queued'|'running'|'complete'|'failed'|'cancelled'} state
 * @property {string|null} error
 * @property {Record<string, any>} options
 * @property {number} done
 * @property {number|null} total
 * @property {number|null} size        bytes
 * @property {string} sha256
 * @property {Record<string, any>} summary   of an export: title, counts, skipped, skipped_count, videos, split
 * @property {string} created
 * @property {string|null} finished
 */

/**
 * @typedef {object} ExportRequest
 * @property {string[]} runs
 * @property {string} format
 * @property {'none'|'annotated'|'all'} pictures
 * @property {string[]} states
 * @property {string[]|null} labels    keys; null: all
 * @property {'leave-out'|'ignore'|'class'} not_in_set   what becomes of signs without a label of the set
 * @property {'all'|'used'} class_map  labels that the files declare
 * @property {boolean} balance_labels
 * @property {number|null} min_side    px
 * @property {number} [first]
 * @property {number|null} [stop]
 * @property {{train: number, val: number, test: number}|null} split
 * @property {'sign'|'video'} [split_by]
 * @property {number} split_seed
 * @property {number} thin_px
 * @property {Record<string, string>} switches
 * @property {Record<string, string[]>} [tracks]   keys of the only tracks that go out, by run; unset: all
 * @property {string} name
 */

/**
 * @typedef {object} ImportResult
 * @property {'annotation'|'truth'|'run'} kind
 * @property {string} id               of the run or the truth
 * @property {number} tracks
 * @property {number} boxes
 * @property {number} [same]           tracks that the run showed already
 * @property {string[]} repaired
 * @property {{what: string, reason: string}[]} skipped
 */

/**
 * A set of model files.
 * @typedef {object} ModelVersion
 * @property {string} id               `shipped`: those of the engine
 * @property {string} name
 * @property {'queued'|'running'|'complete'|'failed'|'cancelled'} state
 * @property {string|null} error
 * @property {string|null} parent_id
 * @property {Record<string, any>} lineage
 * @property {Record<string, any>} figures
 * @property {Record<string, string>} models   part -> SHA-256
 * @property {string} stage
 * @property {number} done
 * @property {number|null} total
 * @property {boolean} active
 * @property {string} created
 * @property {string|null} finished
 * @property {number} [labels]         how many labels it reads
 * @property {string[]} [lacks]        signs of the library's label set that it does not read
 */

/**
 * @typedef {object} ModelRequest
 * @property {string} name
 * @property {string[]} parts
 * @property {string[]} exports        ids of outputs
 * @property {{gtsdb?: string, gtsrb?: string}} folders
 * @property {number} seed
 * @property {string|null} parent
 */

/**
 * `summary.difference` of a complete what-if. Lists hold at most 500 entries, `counts` the full numbers.
 * `gained` and `relabelled` name tracks of the what-if; `lost` and `switched` tracks of the run that it replays.
 * @typedef {object} Difference
 * @property {{gained: number, lost: number, switched: number, relabelled: number}} counts
 * @property {{track: number, frame: number, last: number, class_id: number|null, word?: string|null}[]} gained
 * @property {{track: number, frame: number, last: number, class_id: number|null, word?: string|null}[]} lost
 * @property {{track: number, parts: number[], frame: number}[]} switched
 * @property {{track: number, before: number|null, after: number|null, words?: (string|null)[], frame: number}[]} relabelled
 */

/**
 * What another tau would turn over, from GET /runs/{id}/flips?tau=
 * @typedef {object} Flips
 * @property {number} tau
 * @property {number} run_tau
 * @property {number} verdicts         those of the lanes: of confirmed tracks, up to their last frame
 * @property {number} to_confident
 * @property {number} to_rejected
 * @property {{id: number, flips: number, frame: number}[]} tracks
 */

/** @typedef {{frame: number, box: Box, class_id: number|null, track: number}} GroundTruthBox */

/** @typedef {{frame: number, box: Box}} FollowAnchor   a box that a person has set */
/** @typedef {{direction: 'backward'|'forward', frame: number, reason: string, sentence: string}} FollowEnding   proposals beyond `frame` are withdrawn */

/**
 * A sign that the server follows; what it proposes is nobody's data until it is accepted.
 * @typedef {object} Follow
 * @property {string} id
 * @property {string} run_id
 * @property {string} key              the track
 * @property {FollowAnchor[]} anchors
 * @property {'forward'|'backward'|'between'|null} only
 * @property {number} first
 * @property {number|null} last
 * @property {'queued'|'running'|'complete'|'failed'|'cancelled'} state
 * @property {string|null} error
 * @property {[number, number, number, number, number, number, 'anchor'|'detected'|'matched'|'predicted'][]} proposals   frame, box, confidence, source
 * @property {FollowEnding[]} endings
 * @property {number} next             ask for what comes after this number next time
 */

export {};
