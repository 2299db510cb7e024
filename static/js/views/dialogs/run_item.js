// @ts-check
/** One run in the list of a video's runs: name, progress and actions. */

import { runAddress } from '../../model/route.js';
import { isResumable, runShare } from '../../model/run_progress.js';
import { dropRun, openDialog } from '../../store/actions/page.js';
import { changeRun } from '../change_run.js';
import { h, setAttribute, setText } from '../dom.js';
import { moment, plural } from '../../model/format.js';
import { icon } from '../icons.js';
import { describeRunModels } from '../model_version_text.js';
import { createProgressBar, setProgress } from '../progress_bar.js';
import { runChanges, runInexact, runKind, runName, runProgress, runState, runTone } from '../../model/describe_run.js';
import { toast } from '../../core/toast.js';

/** @typedef {import('../../page-types.js').App} App */
/** @typedef {import('../../types.js').Run} Run */
/** @typedef {ReturnType<typeof import('../../model/run_groups.js').listRuns>[number]} Listed */

/** @param {import('./index.js').DialogSetup} setup @param {Run} run */
export function createRunItem({ app, close, signal }, run) {
  /** The run with its present name. */
  const currentRun = () => app.store.get().runs[run.video_id]?.find(({ id }) => id === run.id) ?? run;
  const address = () => runAddress(app.store.get(), run.video_id, run.id);
  return h(
    'li.run-item',
    h(
      'div.row',
      h('strong.run-name.truncate'),
      renameField(app, signal, run),
      h('span.badge.run-badge'),
      h('span.grow'),
      h('span.muted.small.run-time', moment(run.created)),
    ),
    h('p.run-changes.muted.small'),
    h('p.run-progress.small'),
    h('p.run-inexact.field-warning'),
    createProgressBar('Progress', 'span.meter.run-meter'),
    h(
      'div.row.run-actions',
      h(
        'a.btn.btn-small.run-open',
        {
          href: address(),
          onclick: (/** @type {MouseEvent} */ event) => {
            // a video that plays has moved on
            /** @type {HTMLAnchorElement} */ (event.currentTarget).href = address();
            close();
          },
        },
        'Open',
      ),
      h('button.btn.btn-small.run-cancel', { onclick: () => changeRun(app, () => app.api.cancelRun(run.id), signal) }, 'Cancel'),
      h('button.btn.btn-small.run-resume', { onclick: () => changeRun(app, () => app.api.resumeRun(run.id), signal) }, 'Go on'),
      h(
        'button.btn.btn-small.run-whatif',
        { onclick: () => app.store.dispatch(openDialog, { kind: 'whatif', data: { run: run.id } }) },
        'What if …',
      ),
      h(
        'button.btn.btn-small.run-adopt',
        {
          title: 'Carry the corrections of this run over to the open run',
          onclick: () => {
            const to = app.store.get().review?.run;
            if (to) app.store.dispatch(openDialog, { kind: 'adopted', data: { from: currentRun(), to } });
          },
        },
        'Carry corrections over',
      ),
      h('span.grow'),
      h('button.btn.btn-small.btn-quiet.run-whatifs', { onclick: () => confirmRemovalOfWhatIfs(app, currentRun()) }),
      h('button.btn.btn-small.btn-quiet.run-rename', { title: 'Rename this run', onclick: beginRename }, 'Rename'),
      h(
        'button.btn.btn-small.btn-quiet.btn-icon.run-remove',
        { title: 'Remove this run …', onclick: () => confirmRemoval(app, currentRun()) },
        icon('delete'),
      ),
    ),
  );
}

/** @param {import('./index.js').DialogSetup} setup @param {HTMLElement} item @param {Listed} listed */
export function updateRunItem({ app }, item, { run, isWhatIf: under, whatifs }) {
  /** @param {string} name */
  const find = (name) => /** @type {HTMLElement} */ (item.querySelector(`.run-${name}`));
  const isActive = run.state === 'queued' || run.state === 'running';
  item.classList.toggle('run-under', under);
  setText(find('name'), run.name || runKind(run));
  for (const [name, text] of Object.entries({ rename: 'Rename', remove: 'Remove', 'new-name': 'New name of' }))
    setAttribute(find(name), 'aria-label', `${text} ${runName(run)}`);
  setText(find('badge'), runState(run));
  find('badge').className = `badge run-badge ${runTone(run)}`;
  const range = run.first > 0 || run.stop !== null ? `frames ${run.first} to ${run.stop === null ? 'the end' : run.stop - 1}` : '';
  setText(
    find('changes'),
    [run.name ? runKind(run) : '', range, runChanges(run), describeRunModels(run, app.store.get().models)].filter(Boolean).join(' · '),
  );
  find('changes').hidden = !find('changes').textContent;
  setText(find('progress'), runProgress(run));
  setText(find('inexact'), runInexact(run));
  find('progress').classList.toggle('field-error', run.state === 'failed');
  find('meter').hidden = !isActive;
  setProgress(find('meter'), runShare(run));
  find('cancel').hidden = !isActive;
  find('resume').hidden = !isResumable(run);
  find('whatif').hidden = run.state !== 'complete' || run.kind !== 'engine';
  const openRun = app.store.get().review?.run;
  find('adopt').hidden =
    !openRun || openRun.id === run.id || openRun.video_id !== run.video_id || openRun.state !== 'complete' || run.state !== 'complete';
  find('open').hidden = run.state === 'queued';
  find('whatifs').hidden = whatifs === 0;
  setText(find('whatifs'), `Remove ${whatifs === 1 ? 'its what-if' : `its ${whatifs} what-ifs`} …`);
}

/**
 * A field in place of the name: Enter saves the typed name, Escape does not.
 *
 * @param {App} app
 * @param {AbortSignal} signal
 * @param {Run} run
 */
function renameField(app, signal, run) {
  const input = h('input.input.run-new-name.grow', { type: 'text', maxlength: 120, autocomplete: 'off', hidden: true });
  const hideField = () => {
    if (input.hidden) return;
    input.hidden = true;
    input.closest('.run-item')?.classList.remove('run-renamed');
  };
  input.addEventListener('keydown', (event) => {
    if (event.key !== 'Enter' && event.key !== 'Escape') return;
    event.preventDefault(); // so that Enter does not start a run and Escape does not close the dialog
    event.stopPropagation();
    const name = input.value.trim();
    const item = input.closest('.run-item');
    hideField();
    /** @type {HTMLElement|null|undefined} */ (item?.querySelector('.run-rename'))?.focus();
    if (event.key === 'Enter' && name && name !== item?.querySelector('.run-name')?.textContent)
      void changeRun(app, () => app.api.renameRun(run.id, name), signal);
  });
  input.addEventListener('blur', hideField);
  return input;
}

/** @param {Event} event   the click on the button */
function beginRename(event) {
  const item = /** @type {HTMLElement} */ (/** @type {HTMLElement} */ (event.currentTarget).closest('.run-item'));
  const input = /** @type {HTMLInputElement} */ (item.querySelector('.run-new-name'));
  input.value = item.querySelector('.run-name')?.textContent ?? '';
  input.hidden = false;
  item.classList.add('run-renamed');
  input.focus();
  input.select();
}

/** @param {App} app @param {Run} run */
function confirmRemoval(app, run) {
  app.store.dispatch(openDialog, {
    kind: 'confirm',
    data: {
      title: 'Remove this run?',
      confirm: 'Remove',
      danger: true,
      text: `“${runName(run)}” will be removed with its evidence, its what-ifs, and all its corrections and notes. This cannot be undone.`,
      note: 'The video, its other runs and its ground truth stay.',
      run: async () => {
        await app.api.removeRun(run.id);
        app.store.dispatch(dropRun, run.id);
        toast('The run was removed.');
      },
    },
  });
}

/** @param {App} app @param {Run} run */
function confirmRemovalOfWhatIfs(app, run) {
  app.store.dispatch(openDialog, {
    kind: 'confirm',
    data: {
      title: 'Remove the what-ifs of this run?',
      confirm: 'Remove',
      danger: true,
      text: `All what-ifs of “${runName(run)}” will be removed with their corrections and notes. You can replay them again, but their corrections are lost.`,
      note: 'The run itself and its corrections stay. A what-if that is still being replayed stays too.',
      run: async () => {
        const removedIds = await app.api.removeWhatIfs(run.id);
        app.store.dispatch((now) => removedIds.reduce(dropRun, now));
        toast(
          removedIds.length
            ? `${plural(removedIds.length, 'what-if')} ${removedIds.length === 1 ? 'was' : 'were'} removed.`
            : 'Nothing was removed: they are still being replayed.',
        );
      },
    },
  });
}
