// @ts-check
/**
 * The shapes of data that server, store and views exchange. Types only: this module has no code.
 *
 * A box is `[x1, y1, x2, y2]`, 0-based pixel edges of the upright picture. A frame is its ordinal.
 */

/** @typedef {[number, number, number, number]} Box */
/** @typedef {import('./api/schema.js').components['schemas']} Schemas */

// ------------------------------------------------------------------------------------------------ from the server

/** @typedef {Schemas['ErrorAnswer']} ApiError */
/** @typedef {Schemas['SessionAnswer']} Session */
/** @typedef {Schemas['AttributeView']} Attribute */
/** @typedef {Schemas['LabelView']} Label */
/** @typedef {Schemas['LabelSetView']} LabelSetSummary */
/** @typedef {Schemas['LabelUsage']} LabelUsage */
/** @typedef {Schemas['LabelVersion']} LabelVersion */
/** @typedef {Schemas['PersonView']} Person */
/** @typedef {Schemas['AssignmentView']} Assignment */
/** @typedef {Schemas['Difference'] & {before: any, after: any}} TrackDifference */
/** @typedef {Schemas['Happened']} Happened */
/** @typedef {Schemas['TrackHistory']} TrackHistory */
/** @typedef {Schemas['Worker']} Worker */
/** @typedef {Schemas['Done']} Done */
/** @typedef {Schemas['Activity']} Activity */
/** @typedef {Schemas['Overview']} Overview */
/** @typedef {Schemas['SecondOpinions']} SecondOpinions */
/** @typedef {Schemas['Agreement']} Agreement */
/** @typedef {Schemas['NextLook']} NextLook */
/** @typedef {Schemas['Look']} Look */
/** @typedef {{type: 'add'|'update'|'merge'|'hide'|'show'|'picture'|'undo'|'adopt', [field: string]: unknown}} LabelChange   see docs/labels.md */
/** @typedef {{name: string, tracks: number, boxes: number, suggestions: {id: number, key: string, name: string}[], similar: boolean, example: {frame: number, box: Box}|null}} UnknownLabel   a name in a file that matches no label; similar: the suggestions resemble it, else they only contain it */
/** @typedef {Schemas['Parameter']} Parameter */
/** @typedef {Schemas['VideoView']} Video */
/** @typedef {Schemas['TableAnswer']} FrameTableData */
/** @typedef {Schemas['RunView'] & {summary: Record<string, any>}} Run */
/** @typedef {Schemas['Earlier']} Earlier */
/** @typedef {Schemas['TrackColumns']} TrackColumns */
/** @typedef {Schemas['LaneColumns']} LaneColumns */
/** @typedef {Schemas['TrackLane']} TrackLane */
/** @typedef {Schemas['Overlay']} Overlay */
/** @typedef {Schemas['OverlayTrack']} OverlayTrack */
/** @typedef {Schemas['TrackDoc']} TrackDoc */
/** @typedef {Schemas['FoundTrack']} FoundTrack */

/** @typedef {boolean|number|string} AttributeValue   boolean: checkbox; string: select or text */

/** @typedef {Record<string, AttributeValue>} Attributes   by name */
/** @typedef {Schemas['Segment']} Segment */
/** @typedef {Schemas['KeyFrame']} KeyFrame */
/** @typedef {Schemas['FollowedBox']} FollowedBox */
/** @typedef {Schemas['Note']} Note */

/**
 * One operation. `name` determines which other fields it has; see docs/edits.md.
 * @typedef {object} Command
 * @property {'create_track'|'set_box'|'relabel_track'|'relabel_box'|'merge'|'split'|'delete_from'|'delete_track'|'restore_track'
 *   |'add_key'|'remove_key'|'interpolate'|'follow'|'set_occluded'|'set_outside'|'set_not_a_sign'|'set_review'|'review_tracks'
 *   |'add_note'|'edit_note'|'remove_note'|'ignore'|'attribute'} name
 * @property {number} frame            the frame on the screen
 * @property {string} key              the track
 * @property {string[]} [others]       merge: keys that go into `key`; review_tracks: the other tracks
 * @property {string} [new_key]        split: key of the later part
 * @property {Box|null} [box]
 * @property {string} [label_key]      key of the label of `class_id`; it takes precedence if the label set has changed since
 * @property {number|null} [class_id]  split, merge: the engine's class, for a track that would lose it otherwise
 * @property {Segment[]} [gaps]        merge: frames in which the engine's tracks have no box
 * @property {FollowedBox[]} [boxes]   follow: in ascending order of frames
 * @property {number} [first]          interpolate
 * @property {number} [last]
 * @property {AttributeValue|null} [value]   attribute: null removes it
 * @property {string} [attribute]     name of the attribute
 * @property {boolean} [from_here]    attribute: from this frame on; otherwise in the whole track
 * @property {'open'|'accepted'|'rejected'|'needs_work'} [review]
 * @property {string} [note_id]
 * @property {string} [text]
 * @property {{track: number, first: number, last: number}[]} [spans]  span of each engine track `m...` among `key` and
 *   `others` that has no document yet
 */
/** @typedef {Schemas['Annotation']} Annotation */
/** @typedef {Schemas['Target']} UndoTarget */
/** @typedef {Schemas['EditAnswer']} EditAnswer */

/** @typedef {{seq: number, kind: string, subject: string, data: any}} ServerEvent */
/** @typedef {Schemas['SwitchView']} Switch */
/** @typedef {Schemas['FormatView']} Format */
/** @typedef {Schemas['OutputView'] & {options: Record<string, any>, summary: Record<string, any>}} Output */
/** @typedef {Schemas['ExportRequest']} ExportRequest */
/** @typedef {Schemas['ImportResult']} ImportResult */
/** @typedef {Schemas['ImportProgress']} ImportProgress */
/** @typedef {Schemas['ModelView'] & {lineage: Record<string, any>, figures: Record<string, any>}} ModelVersion */
/** @typedef {Schemas['NewModel']} ModelRequest */

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
/** @typedef {Schemas['Flips']} Flips */
/** @typedef {Schemas['GroundTruthBox']} GroundTruthBox */
/** @typedef {Schemas['FollowAnchor']} FollowAnchor */
/** @typedef {Schemas['FollowEnding']} FollowEnding */
/** @typedef {Schemas['FollowView']} Follow */

export {};
