// @ts-check
/** One run in the list of a video's runs: name, progress and actions. */

import { formatRoute } from '../../model/route.js';
import { isResumable, runShare } from '../../model/run_progress.js';
import { dropRun, openDialog } from '../../store/actions/page.js';
import { changeRun } from '../change_run.js';
import { h, setText } from '../dom.js';
import { moment, plural } from '../../model/format.js';
import { icon } from '../icons.js';
import { modelsOf } from '../model-words.js';
import { createMeter, setMeter } from '../meter.js';
import { runChanges, runInexact, runKind, runName, runProgress, runState, runTone } from '../../model/describe_run.js';
import { toast } from '../../core/toast.js';

/** @typedef {import('../../page-types.js').App} App */
/** @typedef {import('../../types.js').Run} Run */
/** @typedef {ReturnType<typeof import('../../model/run_groups.js').listRuns>[number]} Listed */

/**
 * @param {import('./layer.js').Setup} setup
 * @param {Run} run
 */
export function runItem({ app, close, signal }, run) {
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
    createMeter('Progress', 'span.meter.run-meter'),
    h(
      'div.row.run-actions',
      h(
        'a.btn.btn-small.run-open',
        { href: formatRoute({ screen: 'review', video: run.video_id, run: run.id, frame: null, track: null }), onclick: close },
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
            if (to) app.store.dispatch(openDialog, { kind: 'adopted', data: { from: run, to } });
          },
        },
        'Carry corrections over',
      ),
      h('span.grow'),
      h('button.btn.btn-small.btn-quiet.run-whatifs', { onclick: () => askRemoveWhatIfs(app, run) }),
      h(
        'button.btn.btn-small.btn-quiet.run-rename',
        { 'aria-label': `Rename ${runName(run)}`, title: 'Rename this run', onclick: (/** @type {Event} */ event) => beginRename(event) },
        'Rename',
      ),
      h(
        'button.btn.btn-small.btn-quiet.btn-icon',
        { 'aria-label': `Remove ${runName(run)}`, title: 'Remove this run …', onclick: () => askRemove(app, run) },
        icon('trash'),
      ),
    ),
  );
}

/**
 * @param {import('./layer.js').Setup} setup
 * @param {HTMLElement} item
 * @param {Listed} listed
 */
export function showRun({ app }, item, { run, isWhatIf: under, whatifs }) {
  /** @param {string} name */
  const part = (name) => /** @type {HTMLElement} */ (item.querySelector(`.run-${name}`));
  const open = run.state === 'queued' || run.state === 'running';
  item.classList.toggle('run-under', under);
  setText(part('name'), run.name || runKind(run));
  setText(part('badge'), runState(run));
  part('badge').className = `badge run-badge ${runTone(run)}`;
  const range = run.first > 0 || run.stop !== null ? `frames ${run.first} to ${run.stop === null ? 'the end' : run.stop - 1}` : '';
  setText(
    part('changes'),
    [run.name ? runKind(run) : '', range, runChanges(run), modelsOf(run, app.store.get().models)].filter(Boolean).join(' · '),
  );
  part('changes').hidden = !part('changes').textContent;
  setText(part('progress'), runProgress(run));
  setText(part('inexact'), runInexact(run));
  part('progress').classList.toggle('field-error', run.state === 'failed');
  part('meter').hidden = !open;
  setMeter(part('meter'), runShare(run));
  part('cancel').hidden = !open;
  part('resume').hidden = !isResumable(run);
  part('whatif').hidden = run.state !== 'complete' || run.kind !== 'engine';
  const shown = app.store.get().review?.run;
  part('adopt').hidden =
    !shown || shown.id === run.id || shown.video_id !== run.video_id || shown.state !== 'complete' || run.state !== 'complete';
  part('open').hidden = run.state === 'queued';
  part('whatifs').hidden = whatifs === 0;
  setText(part('whatifs'), `Remove ${whatifs === 1 ? 'its what-if' : `its ${whatifs} what-ifs`} …`);
}

/**
 * A field in place of the name: Enter saves the typed name, Escape does not.
 *
 * @param {App} app
 * @param {AbortSignal} signal
 * @param {Run} run
 */
function renameField(app, signal, run) {
  const input = h('input.input.run-new-name.grow', {
    type: 'text',
    maxlength: 120,
    autocomplete: 'off',
    hidden: true,
    'aria-label': `New name of ${runName(run)}`,
  });
  const end = () => {
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
    end();
    /** @type {HTMLElement|null|undefined} */ (item?.querySelector('.run-rename'))?.focus();
    if (event.key === 'Enter' && name && name !== item?.querySelector('.run-name')?.textContent)
      void changeRun(app, () => app.api.renameRun(run.id, name), signal);
  });
  input.addEventListener('blur', end);
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

/**
 * @param {App} app
 * @param {Run} run
 */
function askRemove(app, run) {
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

/**
 * @param {App} app
 * @param {Run} run
 */
function askRemoveWhatIfs(app, run) {
  app.store.dispatch(openDialog, {
    kind: 'confirm',
    data: {
      title: 'Remove the what-ifs of this run?',
      confirm: 'Remove',
      danger: true,
      text: `All what-ifs of “${runName(run)}” will be removed with their corrections and notes. You can replay them again, but their corrections are lost.`,
      note: 'The run itself and its corrections stay. A what-if that is still being replayed stays too.',
      run: async () => {
        const gone = await app.api.removeWhatIfs(run.id);
        app.store.dispatch((now) => gone.reduce(dropRun, now));
        toast(
          gone.length
            ? `${plural(gone.length, 'what-if')} ${gone.length === 1 ? 'was' : 'were'} removed.`
            : 'Nothing was removed: they are still being replayed.',
        );
      },
    },
  });
}
