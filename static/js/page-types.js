// @ts-check
/** Types that the parts of the page share. They refer to the DOM, so they are not in types.js. Types only. */

/**
 * An action of the user: toolbar, menu, keyboard, palette and help are made from these.
 * @typedef {object} Operation
 * @property {string} id
 * @property {string} label
 * @property {string[]} keys           as the page shows them: `F`, `Ctrl+Z`
 * @property {string} [short]          a shorter label for buttons
 * @property {boolean} [each]          its effect depends on the key that was pressed
 * @property {string} group            its heading in the help
 * @property {string} tooltip
 * @property {boolean} repeats         whether it repeats while its key is held
 * @property {string} [icon]           name of an icon in views/icons.js
 * @property {(state: import('./state-types.js').State) => boolean} available
 * @property {(state: import('./state-types.js').State) => string|null} disabled   the reason as a sentence; null: enabled
 * @property {(app: App) => {label: string, run: () => void}|null} [remedy]   an action that enables it, while it is disabled
 * @property {(app: App, ...args: any[]) => unknown} run
 */

/**
 * What every view receives.
 * @typedef {object} App
 * @property {import('./state-types.js').Store} store
 * @property {import('./api/client.js').Api} api
 * @property {Operation[]} operations
 * @property {any} frames              the picture cache
 * @property {(command: import('./types.js').Command, of?: string|null, gesture?: string) => boolean} edit   apply a command at once, and keep it until the server has stored it;
 *   `of`: the run that the command is for (default: the open one); `gesture`: boxes of one gesture are one undo step
 * @property {import('./editing/editor.js').Editor} editor
 * @property {import('./review/loader.js').Loader} loader
 * @property {import('./review/follow_control.js').FollowControl} following
 * @property {import('./store/catch_up.js').CatchUp['receive']} receive   puts an event of the server into the store
 * @property {import('./store/catch_up.js').CatchUp['load']} load   puts an answer of the server into the store, unless an event has already brought newer data
 * @property {import('./editing/label_sets.js').LabelSets} labels   keeps the labels in the store equal to those of the video on the screen
 * @property {import('./editing/note_drafts.js').NoteDrafts} notes   drafts of notes
 * @property {AbortSignal} signal      aborted when the page ends
 */

/**
 * The part of `App` for views that only dispatch actions.
 * @typedef {Pick<App, 'api'|'load'|'edit'|'notes'> & {store: Pick<import('./state-types.js').Store, 'get'|'dispatch'>}} ViewApp
 */

/** A part of the page that stays as long as the page. @typedef {{element: HTMLElement, update: (state: import('./state-types.js').State) => void}} Part */
/** A part that ends; whoever shows it removes its element. @typedef {Part & {destroy: () => void}} View */
/** @typedef {(app: App) => View} CreateView */
/** @typedef {(app: App) => Part} CreatePart */

export {};
