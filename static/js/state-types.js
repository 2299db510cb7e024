// @ts-check
/**
 * The state of the page. Types only.
 *
 * @typedef {import('./types.js').Output} Output
 * @typedef {import('./types.js').Box} Box
 * @typedef {import('./types.js').Command} Command
 * @typedef {import('./types.js').Label} Label
 * @typedef {import('./types.js').LaneColumns} LaneColumns
 * @typedef {import('./types.js').ModelVersion} ModelVersion
 * @typedef {import('./types.js').Overlay} Overlay
 * @typedef {import('./types.js').Parameter} Parameter
 * @typedef {import('./types.js').Run} Run
 * @typedef {import('./types.js').Session} Session
 * @typedef {import('./types.js').TrackColumns} TrackColumns
 * @typedef {import('./types.js').TrackDoc} TrackDoc
 * @typedef {import('./types.js').TrackLane} TrackLane
 * @typedef {import('./types.js').UndoTarget} UndoTarget
 * @typedef {import('./types.js').Video} Video
 */

/** @typedef {'detections'|'predictions'|'search'|'relocalisations'|'results'|'corrected'|'truth'|'second'|'uncertainty'|'gate'} LayerName */

/** @typedef {{folded: boolean, lane: string}} LanesView   folded: only the value lane with the id `lane` is shown */

/**
 * The whole state of the page. Immutable: actions return a new state that shares its unchanged parts.
 * @typedef {object} State
 * @property {Route} route
 * @property {Session|null} session
 * @property {Label[]} labels                  of the video's label set, else of the library's default; includes merged and hidden ones
 * @property {import('./types.js').LabelSetSummary[]|null} labelSets   null: not loaded yet
 * @property {Parameter[]} parameters
 * @property {Video[]|null} videos             null: not loaded yet
 * @property {Record<string, Run[]>} runs      by video
 * @property {Output[]|null} outputs       null: not loaded yet
 * @property {ModelVersion[]|null} models      newest first; null: not loaded yet
 * @property {import('./types.js').Assignment[]} assignments   empty in a library without people
 * @property {ReviewState|null} review
 * @property {Banner[]} banners
 * @property {{run: string, unsaved: number, held: boolean}[]} elsewhere   operations of other runs that the server has
 *   not acknowledged; held: a person has to decide once the run is opened
 * @property {'online'|'offline'} connection
 * @property {'light'|'dark'|'auto'} theme
 * @property {Record<LayerName, boolean>} layers   as the user left them
 * @property {LanesView} lanesView    how the lanes are shown; as the user left it
 * @property {boolean} fewLabels      the picture names only the selected track and the one under the pointer; as the user left it
 * @property {Dialog|null} dialog
 */

/**
 * @typedef {{screen: 'library'}
 *   | {screen: 'review', video: string, run: string|null, frame: number|null, track: string|null}
 *   | {screen: 'compare', a: string, b: string}
 *   | {screen: 'team', person: string|null}
 *   | {screen: 'search', query: string}
 *   | {screen: 'models'} | {screen: 'files'} | {screen: 'labels'}} Route
 */

/** @typedef {{key: string, frame: number, box: Box}} Draft   a drawn box without a class; it becomes a track when it gets one */

/** @typedef {{id: string, tone: 'info'|'warning'|'error', text: string, action?: {label: string, operation: string}, once?: string}} Banner   once: name under which the page remembers that the user has hidden it */

/** @typedef {import('./dialog-types.js').Dialog} Dialog */

/**
 * @typedef {object} ReviewState
 * @property {Video} video
 * @property {import('./model/timebase.js').Timebase|null} timebase
 * @property {Run|null} run
 * @property {TrackColumns|null} tracks
 * @property {LaneColumns|null} lanes
 * @property {Record<number, TrackLane>} laneOf        of tracks that were selected, by track
 * @property {Record<number, Overlay>} overlays        by frame, a window around the cursor
 * @property {Record<number, Overlay>} secondOverlays
 * @property {TrackColumns|null} secondTracks          null: not loaded yet
 * @property {Record<string, TrackDoc>} secondDocs     its corrections, if the page shows them
 * @property {Record<number, {box: Box, class_id: number|null, track: number}[]>} truth   by frame
 * @property {string|null} truthId                    the ground truth that is shown
 * @property {number|null} truthSign                  the chosen sign of the ground truth
 * @property {string|null} truthName                  its name; null: the video has no ground truth
 * @property {string|null} second                      id of the second run
 * @property {number} frame                            the cursor
 * @property {number|null} shown                       ordinal of the picture on screen; overlays are drawn only if it equals `frame`
 * @property {boolean} playing
 * @property {string|null} selected                    track key
 * @property {Record<LayerName, boolean>} layers
 * @property {boolean} fewLabels
 * @property {string|null} hovered                     track under the pointer, used while few labels are shown
 * @property {import('./model/geometry.js').Viewport} viewport
 * @property {{first: number, last: number}} span      range of frames in the timeline
 * @property {number|null} tau                         the dragged threshold; null: the run's own
 * @property {'select'|'draw'|'merge'} mode
 * @property {string[]} marked                         keys of tracks marked for a merge
 * @property {Record<string, TrackDoc>} docs
 * @property {number|null} seq                      number of the newest edit that has arrived; null: edits are not loaded yet
 * @property {UndoTarget|null} undo
 * @property {UndoTarget|null} redo
 * @property {{op_id: string, command: Command, held: boolean}[]} unsaved   operations that the server has not acknowledged; held: a person has to decide
 * @property {{box: Box, key: string}|null} drag       box under the pointer
 * @property {QueueFilter} filter
 * @property {import('./types.js').Earlier|null} earlier   corrections of an earlier run that can be adopted
 * @property {'recording'|'scene3d'|null} beside         the view beside the picture
 * @property {import('./model/following.js').Following|null} following   a follow in progress, or its result that waits for acceptance
 */

/**
 * @typedef {object} QueueFilter
 * @property {number|null} class_id      null: any; -1: no class
 * @property {'all'|'open'|'accepted'|'rejected'|'needs_work'} review
 * @property {number} least_uncertainty
 * @property {number|null} least_score   minimum of a track's best score, log-odds; null: no limit
 * @property {number|null} most_score
 * @property {{name: string, value: import('./types.js').AttributeValue|null}|null} attribute   value null: any value that a person has set
 * @property {boolean} with_notes        only tracks with notes
 * @property {string} text
 * @property {'uncertainty'|'time'|'class'|'score'} sort
 */

/**
 * A pure function from state to state. Further arguments depend on the action.
 * @typedef {(state: State, ...args: any[]) => State} Action
 */

/**
 * @typedef {object} Store
 * @property {() => State} get
 * @property {<A extends Action>(action: A, ...args: A extends (state: State, ...args: infer P) => State ? P : never) => void} dispatch
 * @property {(listener: (state: State) => void) => (() => void)} subscribe   returns the function that unsubscribes
 */
export {};
