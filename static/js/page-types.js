// @ts-check
/** What the parts of the page hand each other. Apart from types.js, because these touch the document. Types only. */

/**
 * One thing that a person can do: the source of toolbar, menu, keyboard, palette and help.
 * @typedef {object} Operation
 * @property {string} id
 * @property {string} label
 * @property {string[]} keys           as shown: `F`, `Ctrl+Z`
 * @property {string} [short]          where there is little room, as on a button
 * @property {boolean} [each]          it does something else for each of its keys, and needs the one that was pressed
 * @property {string} group            heading in the help
 * @property {string} tooltip
 * @property {boolean} repeats         whether it happens again and again while its key is held
 * @property {string} [icon]           of views/icons.js
 * @property {(state: import('./state-types.js').State) => boolean} available
 * @property {(state: import('./state-types.js').State) => string|null} disabled   a sentence why not, or null
 * @property {(app: App) => {label: string, run: () => void}|null} [remedy]   what makes it possible, where it is disabled
 * @property {(app: App, ...args: any[]) => unknown} run
 */

/**
 * What views are given.
 * @typedef {object} App
 * @property {import('./state-types.js').Store} store
 * @property {import('./api/client.js').Api} api
 * @property {Operation[]} operations
 * @property {any} frames              the picture cache
 * @property {(command: import('./types.js').Command, of?: string|null, gesture?: string) => boolean} edit   apply at once, send, keep until the server has it;
 *   `of`: the run that it is meant for, whichever is on the screen by now; `gesture`: boxes that it sets without a pause are one step
 * @property {import('./editing/editor.js').Editor} editor
 * @property {import('./review/loader.js').Loader} loader
 * @property {import('./review/following.js').FollowControl} following
 * @property {import('./store/catch_up.js').CatchUp['receive']} receive   what the server tells, into the store
 * @property {import('./store/catch_up.js').CatchUp['load']} load   what the server is asked, into the store, never older than what was heard
 * @property {import('./editing/label_sets.js').LabelSets} labels   keeps the store's labels those of what is on the screen
 * @property {import('./editing/note_drafts.js').NoteDrafts} notes   those that are half written
 * @property {AbortSignal} signal      ends with the page
 */

/**
 * What the views need that do not change the store otherwise than by actions.
 * @typedef {Pick<App, 'api'|'load'|'edit'|'notes'> & {store: Pick<import('./state-types.js').Store, 'get'|'dispatch'>}} ViewApp
 */

/** @typedef {{element: HTMLElement, update: (state: import('./state-types.js').State) => void, destroy: () => void}} View */

export {};
