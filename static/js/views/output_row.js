// @ts-check
/** One file that was made from runs: state, progress, omitted data, download, removal. */

import { formatRoute } from '../model/route.js';
import { dropOutputOrModel, openDialog, putOutput } from '../store/actions/page.js';
import { describeContent, describeOutput, isActive, KINDS, progressOf, skippedItems, stateBadge, outputWarnings } from './output_text.js';
import { fill, h, setText } from './dom.js';
import { count, plural } from '../model/format.js';
import { icon, iconButton } from './icons.js';
import { createProgressBar, setProgress } from './progress_bar.js';
import { toast } from '../core/toast.js';
import { toastErrors } from './toast_errors.js';

/** @typedef {import('../page-types.js').App} App */
/** @typedef {import('../types.js').Output} Output */
/** @typedef {import('../state-types.js').State} State */

/** @param {App} app @param {Output} initialOutput @returns {{element: HTMLLIElement, show: (output: Output) => void}} */
export function createOutputRow(app, initialOutput) {
  const nameElement = h('strong.truncate.made-name', initialOutput.name);
  const badge = h('span.badge');
  const description = h('p.muted.small.made-facts');
  const bar = createProgressBar(`Progress of ${initialOutput.name}`);
  const statusText = h('p.small.made-words');
  const actions = h('div.row.made-actions');
  const warningList = h('ul.skipped-list.small.made-warnings', { hidden: true });
  const skippedDetails = h('details.details.made-skipped', h('summary'), h('ul.skipped-list.small'));
  const element = h(
    'li.made',
    h('span.made-icon', icon(KINDS[initialOutput.kind]?.icon ?? 'folder')),
    h('div.stack.made-text', h('div.row', nameElement, badge), description, bar, statusText, warningList, skippedDetails),
    actions,
  );
  /** @type {Output|null} */ let shown = null;
  let shownVideoNames = '';
  let shownWithRun = false;

  /** @param {Output} output */
  function show(output) {
    const videoNames = describeVideos(app.store.get(), output);
    // the run may be loaded after the list of files
    const hasRun = runOf(app.store.get(), output.run_id) !== undefined;
    if (output === shown && videoNames === shownVideoNames && hasRun === shownWithRun) return;
    const hasSameActions = output.state === shown?.state && hasRun === shownWithRun;
    [shown, shownVideoNames, shownWithRun] = [output, videoNames, hasRun];
    const [text, tone] = stateBadge(output);
    setText(badge, text);
    badge.className = `badge ${tone}`;
    setText(description, describeOutput(output, videoNames));
    showProgress(output);
    showSkipped(output);
    const messages = outputWarnings(output);
    warningList.hidden = messages.length === 0;
    fill(warningList, ...messages.map((message) => h('li', message)));
    if (!hasSameActions) fill(actions, ...actionsOf(app, output));
  }

  /** @param {Output} output */
  function showProgress(output) {
    const active = isActive(output);
    bar.hidden = !active;
    setProgress(bar, progressOf(output));
    const status =
      output.state === 'queued'
        ? 'Waiting for a free worker.'
        : active
          ? output.total
            ? `${count(output.done)} of ${count(output.total)}`
            : 'Starting …'
          : output.state === 'failed'
            ? (output.error ?? 'It failed without saying why; the terminal of the server has more.')
            : describeContent(output);
    setText(statusText, status);
    statusText.hidden = !status;
    statusText.classList.toggle('field-error', output.state === 'failed');
  }

  /** @param {Output} output */
  function showSkipped(output) {
    const { items, total } = skippedItems(output);
    skippedDetails.hidden = total === 0;
    if (total === 0) return;
    setText(/** @type {HTMLElement} */ (skippedDetails.querySelector('summary')), `${plural(total, 'thing')} left out or noted`);
    fill(/** @type {HTMLElement} */ (skippedDetails.querySelector('ul')), ...skippedListItems(items, total));
  }

  show(initialOutput);
  return { element, show };
}

/**
 * @param {{what: string, reason: string}[]} items
 * @param {number} total   total number, may exceed the number of items
 */
export function skippedListItems(items, total) {
  return [
    ...items.map(({ what, reason }) => h('li', h('strong', what), `: ${reason}`)),
    total > items.length ? h('li.muted', `and ${count(total - items.length)} more, all of them in manifest.json`) : null,
  ];
}

/**
 * Names of the videos in a file.
 *
 * @param {State} state
 * @param {Output} output
 */
export function describeVideos(state, output) {
  if (Array.isArray(output.summary.videos) && output.summary.videos.length) {
    const names = output.summary.videos.map(({ name }) => String(name));
    return names.length > 2 ? `${names[0]} and ${names.length - 1} more` : names.join(', ');
  }
  const run = runOf(state, output.run_id);
  return state.videos?.find(({ id }) => id === run?.video_id)?.name ?? '';
}

/** @param {State} state @param {string|null} id */
const runOf = (state, id) =>
  id === null
    ? undefined
    : Object.values(state.runs)
        .flat()
        .find((run) => run.id === id);

/** @param {App} app @param {Output} output */
function actionsOf(app, output) {
  if (isActive(output)) {
    return [
      h(
        'button.btn.btn-small',
        {
          'aria-label': `Cancel ${output.name}`,
          onclick: () => toastErrors(() => app.load(() => app.api.cancelOutput(output.id), putOutput), app.signal),
        },
        'Cancel',
      ),
    ];
  }
  const run = runOf(app.store.get(), output.run_id);
  const frame = output.options.frame ?? output.options.first;
  return [
    output.state === 'complete' &&
      run &&
      output.kind !== 'export' &&
      h(
        'a.btn.btn-small.btn-quiet',
        {
          'aria-label': `Show the run of ${output.name}`,
          title: 'Go to the run that it was made from',
          href: formatRoute({
            screen: 'review',
            video: run.video_id,
            run: run.id,
            frame: typeof frame === 'number' ? frame : null,
            track: null,
          }),
        },
        icon('eye'),
      ),
    output.state === 'complete' &&
      output.kind === 'export' &&
      h(
        'button.btn.btn-small.btn-quiet',
        {
          'aria-label': `Retrain from ${output.name}`,
          title: 'Make a new model version from these corrections',
          onclick: () => app.store.dispatch(openDialog, { kind: 'retrain', data: { exports: [output.id] } }),
        },
        'Retrain',
      ),
    output.state === 'complete' &&
      h(
        'a.btn.btn-small',
        { href: app.api.downloadUrl(output.id), download: output.name, 'aria-label': `Download ${output.name}` },
        'Download',
      ),
    iconButton('delete', `Delete ${output.name}`, () => confirmRemoval(app, output), 'Delete …'),
  ];
}

/** @param {App} app @param {Output} output */
function confirmRemoval(app, output) {
  const remove = async () => {
    await app.api.removeOutput(output.id);
    app.store.dispatch(dropOutputOrModel, output.id);
    toast(`${output.name} was deleted.`);
  };
  if (output.state !== 'complete') {
    void toastErrors(remove, app.signal);
    return;
  }
  app.store.dispatch(openDialog, {
    kind: 'confirm',
    data: {
      title: 'Delete this file?',
      confirm: 'Delete',
      danger: true,
      run: remove,
      text: `${output.name} will be deleted from the data folder. Its source data stays, so it can be made again while that does not change.`,
    },
  });
}
