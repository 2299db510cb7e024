// @ts-check
/**
 * The data of each kind of dialog. Types only.
 *
 * - adopted: `now`: the user has asked for it already
 * - confirm: `run` may return a promise; the dialog shows its error
 * - conflict: `others`: who saved the tracks
 * - export: `runs`: selected at first; `tracks`: restricts the export to these tracks, by run
 * - import: `back`: called when the dialog closes; null: nothing was imported
 * - label: `label`: the label to edit; without it the dialog makes a new one
 * - relabel: a track, or a `draft`: a drawn box that becomes a track with its label
 * - retrain: `exports`: selected at first
 * - run-several: `done` receives the ids of the videos for which a run was started
 * - tags: `done` is called after a change
 * - whatif: `run`: default: the run that is open in the review
 *
 * @typedef {import('./types.js').Label} Label
 * @typedef {import('./types.js').Run} Run
 * @typedef {{author: string, time: string, name: string, frame: number|null}} Last   the last change of a track, and its author
 *
 * @typedef {object} Plan   what "Keep mine" would do
 * @property {import('./types.js').Command[]} commands               in the order of their execution
 * @property {import('./types.js').TrackDoc[]} saved                 the tracks that they change, in the server's version
 * @property {import('./types.js').TrackDoc[]} mine                  the same tracks after the commands
 * @property {{key: string, into: string|null}[]} moved   tracks that no longer exist: deleted, or merged into `into`
 * @property {{name: string, why: string}[]} lost         edits that are no longer possible
 *
 * @typedef {{
 *   'add-video': {},
 *   adopted: {from: Run, to: Run, now?: boolean},
 *   assign: {video: string},
 *   'bulk-review': {},
 *   bundle: {},
 *   'choose-label': {title: string, labels: Label[], take: (label: Label) => void},
 *   compare: {video: string, run?: string|null, reference?: string, candidate?: string},
 *   confirm: {title: string, text: string, note?: string|false|null, confirm: string, danger?: boolean, run: () => unknown},
 *   conflict: Plan & {others: Record<string, Last>, keepMine: () => unknown, takeTheirs: () => unknown},
 *   deleted: {},
 *   export: {runs?: string[], tracks?: Record<string, string[]>},
 *   'ground-truths': {video: string},
 *   help: {},
 *   import: {video: string, file?: File, as?: 'annotation'|'truth'|'run', back?: (found: import('./types.js').ImportResult|null) => void},
 *   'import-bundle': {file?: File},
 *   label: {set: string, labels: Label[], label?: Label|null},
 *   'label-files': {set: string},
 *   'label-history': {set: string},
 *   'label-merge': {set: string, labels: Label[], label: Label, usage: import('./types.js').LabelUsage|null},
 *   merge: {marked: string[]},
 *   note: {key?: string|null, frame?: number, note_id?: string, text?: string},
 *   palette: {},
 *   record: {},
 *   relabel: {key?: string|null, frame?: number, scope?: 'track'|'box', draft?: import('./state-types.js').Draft},
 *   retrain: {exports?: string[]},
 *   'return-work': {assignment: import('./types.js').Assignment},
 *   run: {video: string},
 *   'run-queue': {},
 *   'run-several': {videos: import('./types.js').Video[], done?: (ids: string[]) => void},
 *   second: {},
 *   settings: {},
 *   tags: {videos: string[], known: string[], done: () => void},
 *   whatif: {run?: string},
 * }} DialogData
 *
 * @typedef {keyof DialogData} DialogKind
 */

/** `data` may be omitted if all its fields are optional. @typedef {{[K in DialogKind]: {kind: K} & ({} extends DialogData[K] ? {data?: DialogData[K]} : {data: DialogData[K]})}[DialogKind]} Dialog */

export {};
