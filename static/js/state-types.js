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

/** @typedef {{folded: boolean, lane: string}} LanesView   folded: of the values behind a track only the lane of this id is shown */

/**
 * The whole state of the page. Immutable: actions return a new one that shares what did not change.
 * @typedef {object} State
 * @property {Route} route
 * @property {Session|null} session
 * @property {Label[]} labels                  of the set of the video on the screen, else of the library's; merged and hidden ones too
 * @property {import('./types.js').LabelSetHead[]|null} labelSets   null: not loaded yet
 * @property {Parameter[]} parameters
 * @property {Video[]|null} videos             null: not loaded yet
 * @property {Record<string, Run[]>} runs      by video
 * @property {Output[]|null} outputs       null: not loaded yet
 * @property {ModelVersion[]|null} models      the newest first; null: not loaded yet
 * @property {import('./types.js').Assignment[]} assignments   who works on what; empty without people
 * @property {ReviewState|null} review
 * @property {Banner[]} banners
 * @property {{run: string, unsaved: number, held: boolean}[]} elsewhere   operations of runs that are not open without an
 *   acknowledgement yet; held: a person has to decide, once the run is opened
 * @property {'online'|'offline'} connection
 * @property {'light'|'dark'|'auto'} theme
 * @property {Record<LayerName, boolean>} layers   as a person left them
 * @property {LanesView} lanesView    how the lanes are shown, as a person left it
 * @property {boolean} fewLabels      only the selected track and the one under the pointer are named in the picture; as a person left it
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

/** @typedef {{key: string, frame: number, box: Box}} Draft   a box that was drawn and has no class yet: not a track until it gets one */

/** @typedef {{id: string, tone: 'info'|'warning'|'error', text: string, action?: {label: string, operation: string}, once?: string}} Banner   once: under this name it is put away for good when a person hides it */

/** @typedef {import('./dialog-types.js').Dialog} Dialog */

/**
 * @typedef {object} ReviewState
 * @property {Video} video
 * @property {import('./model/timebase.js').Timebase|null} timebase
 * @property {Run|null} run
 * @property {TrackColumns|null} tracks
 * @property {LaneColumns|null} lanes
 * @property {Record<number, TrackLane>} laneOf        lanes of tracks that have been selected
 * @property {Record<number, Overlay>} overlays        by frame, a window around the cursor
 * @property {Record<number, Overlay>} secondOverlays
 * @property {TrackColumns|null} secondTracks          null: not loaded yet
 * @property {Record<string, TrackDoc>} secondDocs     its corrections, where they are to be seen
 * @property {Record<number, {box: Box, class_id: number|null, track: number}[]>} truth   by frame
 * @property {string|null} truthId                    the ground truth that is shown
 * @property {number|null} truthSign                  its sign that is chosen
 * @property {string|null} truthName                  whose boxes these are; null: the video has no ground truth
 * @property {string|null} second                      the second run
 * @property {number} frame                            the cursor
 * @property {number|null} shown                       ordinal of the picture on screen; overlays are drawn only where it equals `frame`
 * @property {boolean} playing
 * @property {string|null} selected                    track key
 * @property {Record<LayerName, boolean>} layers
 * @property {boolean} fewLabels
 * @property {string|null} hovered                     track under the pointer, while few are named
 * @property {import('./model/geometry.js').Viewport} viewport
 * @property {{first: number, last: number}} span      frames that the lanes show
 * @property {number|null} tau                         dragged tau; null: the run's
 * @property {'select'|'draw'|'merge'} mode
 * @property {string[]} marked                         keys marked for a merge
 * @property {Record<string, TrackDoc>} docs
 * @property {number|null} seq                      of the newest edit that is here; null: what people have edited has not come yet
 * @property {UndoTarget|null} undo
 * @property {UndoTarget|null} redo
 * @property {{op_id: string, command: Command, held: boolean}[]} unsaved   operations without an acknowledgement yet; held: a person has to decide
 * @property {{box: Box, key: string}|null} drag       box under the pointer
 * @property {QueueFilter} filter
 * @property {import('./types.js').Earlier|null} earlier   corrections of an earlier run that are offered to this one
 * @property {'recording'|'scene3d'|null} beside         what stands beside the picture
 * @property {import('./model/following.js').Following|null} following   a sign that is being followed, or waits to be accepted
 */

/**
 * @typedef {object} QueueFilter
 * @property {number|null} class_id      null: any; -1: without a class
 * @property {'all'|'open'|'accepted'|'rejected'|'needs_work'} review
 * @property {number} least_uncertainty
 * @property {number|null} least_score   best score of a track, log-odds; null: any, also none at all
 * @property {number|null} most_score
 * @property {{name: string, value: import('./types.js').AttributeValue|null}|null} attribute   value null: any that a person has given
 * @property {boolean} with_notes        only tracks that somebody has written a note on
 * @property {string} text
 * @property {'uncertainty'|'time'|'class'|'score'} sort
 */

/**
 * A pure step from state to state; further arguments are its own.
 * @typedef {(state: State, ...args: any[]) => State} Action
 */

/**
 * @typedef {object} Store
 * @property {() => State} get
 * @property {<A extends Action>(action: A, ...args: A extends (state: State, ...args: infer P) => State ? P : never) => void} dispatch
 * @property {(listener: (state: State) => void) => (() => void)} subscribe   returns what ends it
 */
export {};
