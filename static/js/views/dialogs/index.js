// @ts-check
/**
 * Shows the dialog that the state names in a native `<dialog>`: the browser keeps the focus inside, Escape closes it,
 * and the focus then returns to its earlier place.
 */

import { closeDialog } from '../../store/actions/page.js';
import { h } from '../dom.js';
import { icon } from '../icons.js';
import { addVideoDialog } from './add_video.js';
import { adoptedDialog } from './adopted.js';
import { assignDialog } from './assign.js';
import { bundleDialog } from './bundle.js';
import { compareDialog } from './compare.js';
import { confirmDialog } from './confirm.js';
import { conflictDialog } from './conflict.js';
import { deletedDialog } from './deleted.js';
import { exportDialog } from './export.js';
import { helpDialog } from './help.js';
import { importDialog } from './import.js';
import { importBundleDialog } from './import_bundle.js';
import { bulkReviewDialog } from './bulk_review.js';
import { chooseLabelDialog } from './choose_label.js';
import { labelDialog } from './label.js';
import { labelFilesDialog } from './label_files.js';
import { labelHistoryDialog } from './label_history.js';
import { labelMergeDialog } from './label_merge.js';
import { mergeDialog } from './merge.js';
import { noteDialog } from './note.js';
import { commandPaletteDialog } from './command_palette.js';
import { recordDialog } from './record.js';
import { relabelDialog } from './relabel.js';
import { retrainDialog } from './retrain.js';
import { returnWorkDialog } from './return_work.js';
import { runDialog } from './run.js';
import { runQueueDialog } from './run_queue.js';
import { runSeveralDialog } from './run_several.js';
import { secondRunDialog } from './second_run.js';
import { settingsDialog } from './settings.js';
import { tagsDialog } from './tags.js';
import { groundTruthsDialog } from './ground_truths.js';
import { whatIfDialog } from './whatif.js';

/** @typedef {import('../../page-types.js').App} App */
/** @typedef {import('../../dialog-types.js').Dialog} Dialog */
/** @typedef {import('../../dialog-types.js').DialogKind} DialogKind */

/**
 * @typedef {object} DialogContent
 * @property {string} title
 * @property {HTMLElement} body
 * @property {HTMLElement[]} [footer]
 * @property {'narrow'|'middle'|'wide'} [size]
 * @property {'left'|'right'} [side]      its side of the screen; default: centre
 * @property {HTMLElement} [focus]        the first element to focus
 * @property {() => void} [submit]        Enter in a field, or the primary button
 * @property {(state: import('../../state-types.js').State) => void} [update]
 * @property {() => void} [closed]        after its end, unless another dialog has taken its place
 */

/**
 * @template {DialogKind} [K=DialogKind]
 * @typedef {object} DialogSetup
 * @property {App} app
 * @property {import('../../dialog-types.js').DialogData[K]} data
 * @property {() => void} close
 * @property {AbortSignal} signal   aborted when the dialog closes
 */

/** @template {DialogKind} K @typedef {(setup: DialogSetup<K>) => DialogContent} CreateDialog */

/** @type {{[K in DialogKind]: CreateDialog<K>}} */
const KINDS = {
  'add-video': addVideoDialog,
  adopted: adoptedDialog,
  assign: assignDialog,
  bundle: bundleDialog,
  compare: compareDialog,
  confirm: confirmDialog,
  conflict: conflictDialog,
  deleted: deletedDialog,
  export: exportDialog,
  help: helpDialog,
  import: importDialog,
  'import-bundle': importBundleDialog,
  'bulk-review': bulkReviewDialog,
  'choose-label': chooseLabelDialog,
  label: labelDialog,
  'label-files': labelFilesDialog,
  'label-history': labelHistoryDialog,
  'label-merge': labelMergeDialog,
  merge: mergeDialog,
  note: noteDialog,
  palette: commandPaletteDialog,
  'return-work': returnWorkDialog,
  record: recordDialog,
  relabel: relabelDialog,
  retrain: retrainDialog,
  run: runDialog,
  'run-queue': runQueueDialog,
  'run-several': runSeveralDialog,
  second: secondRunDialog,
  settings: settingsDialog,
  tags: tagsDialog,
  'ground-truths': groundTruthsDialog,
  whatif: whatIfDialog,
};

/** @type {import('../../page-types.js').CreatePart} */
export function createDialogs(app) {
  const element = h('div.dialog-layer');
  /** @type {{dialog: Dialog, element: HTMLDialogElement, content: DialogContent, lifetime: AbortController}|null} */
  let current = null;

  /** @param {Dialog} dialog */
  function show(dialog) {
    const close = () => {
      const isLast = app.store.get().dialog === dialog;
      // Another dialog may already be requested but not drawn yet: the end of this one must not close it.
      app.store.dispatch((state) => (state.dialog === dialog ? closeDialog(state) : state));
      // at once: keys typed before the next drawing are not for this dialog any more
      if (current?.dialog === dialog && app.store.get().dialog === null) hide();
      if (isLast) content.closed?.();
    };
    const lifetime = new AbortController();
    // The dialog edits the run on which it was opened, even if another run is on the screen by now.
    const run = app.store.get().review?.run?.id ?? null;
    const create = /** @type {(setup: DialogSetup<any>) => DialogContent} */ (KINDS[dialog.kind]);
    const content = create({
      app: { ...app, edit: (command) => app.edit(command, run) },
      data: dialog.data ?? {},
      close,
      signal: AbortSignal.any([lifetime.signal, app.signal]),
    });
    const dialogElement = h(
      'dialog',
      {
        class: `dialog dialog-${content.size ?? 'middle'} dialog-${dialog.kind} ${content.side ? `dialog-${content.side}` : ''}`,
        'aria-labelledby': 'dialog-title',
      },
      h(
        'form.dialog-form',
        {
          method: 'dialog',
          novalidate: true,
          onsubmit: (/** @type {Event} */ event) => {
            event.preventDefault();
            content.submit?.();
          },
        },
        h(
          'header.dialog-head',
          h('h2', { id: 'dialog-title', tabIndex: -1 }, content.title),
          h('button.btn.btn-quiet.btn-icon', { 'aria-label': 'Close', title: 'Close (Esc)', onclick: close }, icon('close')),
        ),
        h('div.dialog-body', content.body),
        content.footer && h('footer.dialog-foot', ...content.footer),
      ),
    );
    // Keys of the review screen stay out of a dialog; Escape is the dialog's own.
    dialogElement.addEventListener('keydown', (event) => event.stopPropagation());
    dialogElement.addEventListener('close', close);
    dialogElement.addEventListener('pointerdown', (event) => {
      if (event.target === dialogElement && ['help', 'palette'].includes(dialog.kind)) close();
    });
    element.append(dialogElement);
    dialogElement.showModal();
    (content.focus ?? dialogElement.querySelector('h2'))?.focus();
    current = { dialog, element: dialogElement, content, lifetime };
  }

  function hide() {
    const previous = current;
    current = null;
    previous?.lifetime.abort();
    previous?.element.close();
    previous?.element.remove();
    // the element that opened it may no longer exist, for example a card's button after the first run: keys belong to
    // the screen
    if (previous && document.activeElement === document.body) document.querySelector('main')?.focus();
  }

  return {
    element,
    update(state) {
      if ((current?.dialog ?? null) !== state.dialog) {
        hide();
        if (state.dialog) show(state.dialog);
      }
      current?.content.update?.(state);
    },
  };
}
