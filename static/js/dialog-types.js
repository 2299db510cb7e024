// @ts-check
/**
 * What each kind of dialog is opened with. Types only.
 *
 * - adopted: `now`: it was asked for already
 * - confirm: `run` may return a promise, its error is shown
 * - conflict: `others`: who saved
 * - export: the runs that are ticked at first; the only tracks of them
 * - label: the one that is changed, else a new one
 * - relabel: a track, or a `draft`: a drawn box that becomes a track with its label
 * - retrain: the exports that are ticked at first
 * - run-several: `done` is told the ids of those that have a run now
 * - tags: `done` is called when they have changed
 * - whatif: `run`: that of the review where it is left out
 *
 * @typedef {import('./types.js').Label} Label
 * @typedef {import('./types.js').Run} Run
 * @typedef {{author: string, time: string, name: string, frame: number|null}} Last   what was done to a track last, by whom
 *
 * @typedef {object} Plan   what "Keep mine" would do
 * @property {import('./types.js').Command[]} commands               in order
 * @property {import('./types.js').TrackDoc[]} saved                 tracks that they change, as the server has them
 * @property {import('./types.js').TrackDoc[]} mine                  the same with them
 * @property {{key: string, into: string|null}[]} moved   tracks that are gone: deleted, or merged into another one
 * @property {{name: string, why: string}[]} lost         edits that make no sense any more
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
 *   import: {video: string, file?: File, as?: 'annotation'|'truth'|'run'},
 *   'import-bundle': {file?: File},
 *   label: {set: string, labels: Label[], label?: Label|null},
 *   'label-files': {set: string},
 *   'label-history': {set: string},
 *   'label-merge': {set: string, labels: Label[], label: Label, usage: {tracks: number, videos: number}|null},
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

/** Where nothing has to be said, `data` may be left out. @typedef {{[K in DialogKind]: {kind: K} & ({} extends DialogData[K] ? {data?: DialogData[K]} : {data: DialogData[K]})}[DialogKind]} Dialog */

export {};
