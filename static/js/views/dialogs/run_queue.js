// @ts-check
/** Runs in progress or waiting for a worker. Waiting runs can be reordered by drag or keyboard. */

import { errorMessage } from '../../api/errors.js';
import { runShare } from '../../model/run_progress.js';
import { changeRun } from '../change_run.js';
import { h, reconcile, setText } from '../dom.js';
import { emptyState } from '../placeholders.js';
import { count, plural } from '../../model/format.js';
import { icon } from '../icons.js';
import { createProgressBar, setProgress } from '../progress_bar.js';
import { runKind, runProgress } from '../../model/describe_run.js';
import { toastErrors } from '../toast_errors.js';

/** @typedef {import('../../types.js').Run} Run */

/** Interval of reloads while the queue changes, ms. */
const RELOAD_DELAY_MS = 1000;

/** @type {import('./index.js').CreateDialog<'run-queue'>} */
export function runQueueDialog({ app, close, signal }) {
  const list = h('ol.line', { 'aria-label': 'Runs in queue order' });
  const statusText = h('p.muted.small', { role: 'status' });
  const emptyElement = h(
    'div',
    { hidden: true },
    emptyState({ icon: 'run', title: 'No run waits', text: 'Started runs are listed here until a worker has finished them.' }),
  );
  /** @type {Run[]} */ let runs = [];
  /** @type {string|null} */ let draggedId = null;
  /** @type {readonly import('../../types.js').Video[]|null|undefined} */ let videos;
  /** @type {Record<string, Run[]>|undefined} */ let knownRuns;
  /** @type {ReturnType<typeof setTimeout>|undefined} */ let reloadTimer;
  let latestRequest = 0;
  signal.addEventListener('abort', () => clearTimeout(reloadTimer));

  async function load() {
    reloadTimer = undefined;
    const request = ++latestRequest;
    try {
      const queue = await app.api.runQueue({ signal });
      if (request !== latestRequest) return; // a later request has overtaken this answer
      runs = queue;
      draw();
    } catch (thrown) {
      if (!signal.aborted) setText(statusText, errorMessage(thrown));
    }
  }

  function draw() {
    const names = new Map((app.store.get().videos ?? []).map(({ id, name }) => [id, name]));
    const waitingRuns = runs.filter(({ state }) => state === 'queued');
    const focused = document.activeElement;
    reconcile(
      list,
      runs,
      ({ id }) => id,
      row,
      (item, run) => show(item, run, names.get(run.video_id) ?? 'A video', waitingRuns),
    );
    // an element that is moved in the page loses the focus
    if (focused instanceof HTMLElement && list.contains(focused)) focused.focus();
    emptyElement.hidden = runs.length > 0;
    setText(
      statusText,
      runs.length === 0 ? '' : `${plural(runs.length - waitingRuns.length, 'run')} in progress, ${count(waitingRuns.length)} waiting.`,
    );
  }

  /** @param {Run} run */
  function row(run) {
    /** @param {number} offset */
    const button = (offset) =>
      h(
        'button.btn.btn-small.btn-quiet.btn-icon',
        { dataset: { by: String(offset) }, onclick: () => step(run.id, offset) },
        icon(offset < 0 ? 'up' : 'down'),
      );
    return h(
      'li.line-run',
      {
        draggable: 'false',
        tabIndex: -1,
        onkeydown: (/** @type {KeyboardEvent} */ event) => {
          const offset = event.altKey ? { ArrowUp: -1, ArrowDown: 1 }[event.key] : undefined;
          if (offset === undefined) return;
          event.preventDefault();
          step(run.id, offset);
        },
        ondragstart: (/** @type {DragEvent} */ event) => {
          draggedId = run.id;
          event.dataTransfer?.setData('text/plain', run.id);
        },
        ondragend: () => {
          draggedId = null;
          markDropPosition(null, false);
        },
        ondragover: (/** @type {DragEvent} */ event) => {
          if (draggedId === null || !isWaiting(run.id)) return;
          event.preventDefault();
          markDropPosition(/** @type {HTMLElement} */ (event.currentTarget), isInLowerHalf(event));
        },
        ondrop: (/** @type {DragEvent} */ event) => {
          event.preventDefault();
          if (draggedId !== null) void move(draggedId, isInLowerHalf(event) ? runIdAfter(run.id, 1) : run.id);
        },
      },
      h('span.line-grip', { 'aria-hidden': 'true' }, '⠿'),
      h('span.line-words', h('strong.truncate.line-name'), h('span.muted.small.line-facts'), createProgressBar('Run')),
      button(-1),
      button(1),
      h(
        'button.btn.btn-small.line-cancel',
        { onclick: () => changeRun(app, () => app.api.cancelRun(run.id), signal).then(load) },
        'Cancel',
      ),
    );
  }

  /** @param {HTMLElement} item @param {Run} run @param {string} video @param {readonly Run[]} waitingRuns */
  function show(item, run, video, waitingRuns) {
    const position = waitingRuns.findIndex(({ id }) => id === run.id);
    item.draggable = position >= 0;
    item.classList.toggle('line-waits', position >= 0);
    setText(/** @type {HTMLElement} */ (item.querySelector('.line-name')), video);
    setText(
      /** @type {HTMLElement} */ (item.querySelector('.line-facts')),
      [run.name || runKind(run), position < 0 ? runProgress(run) : `${count(position + 1)}. in the queue`].join(' · '),
    );
    const meter = /** @type {HTMLElement} */ (item.querySelector('.meter'));
    meter.hidden = position >= 0;
    setProgress(meter, runShare(run));
    for (const button of /** @type {NodeListOf<HTMLButtonElement>} */ (item.querySelectorAll('[data-by]'))) {
      const up = button.dataset.by === '-1';
      button.hidden = position < 0;
      // not disabled, because the focus would be lost between steps
      button.setAttribute('aria-disabled', String(up ? position === 0 : position === waitingRuns.length - 1));
      button.title = up ? 'Earlier (Alt+↑)' : 'Later (Alt+↓)';
      button.setAttribute('aria-label', `${video}: ${up ? 'earlier' : 'later'}`);
    }
    /** @type {HTMLElement} */ (item.querySelector('.line-cancel')).setAttribute('aria-label', `Cancel the run of ${video}`);
  }

  /** Ids of waiting runs, in order. */
  const waitingIds = () => runs.filter(({ state }) => state === 'queued').map(({ id }) => id);

  /** The waiting run `offset` places after another one; null: the end. @param {string} id @param {number} offset */
  const runIdAfter = (id, offset) => waitingIds()[waitingIds().indexOf(id) + offset] ?? null;

  /** @param {string} id */
  const isWaiting = (id) => waitingIds().includes(id);

  /** @param {DragEvent} event   over a row */
  const isInLowerHalf = (event) => {
    const { top, height } = /** @type {HTMLElement} */ (event.currentTarget).getBoundingClientRect();
    return event.clientY > top + height / 2;
  };

  /** @param {HTMLElement|null} item @param {boolean} isBelow */
  function markDropPosition(item, isBelow) {
    for (const other of list.children) {
      other.classList.toggle('line-above', other === item && !isBelow);
      other.classList.toggle('line-below', other === item && isBelow);
    }
  }

  /** @param {string} id @param {number} offset */
  function step(id, offset) {
    const index = waitingIds().indexOf(id);
    if (index < 0 || !waitingIds()[index + offset]) return;
    void move(id, runIdAfter(id, offset < 0 ? -1 : 2));
  }

  /** @param {string} id @param {string|null} before */
  async function move(id, before) {
    if (id === before) return;
    await toastErrors(() => app.api.moveRun(id, before, { signal }), signal);
    await load();
  }

  void load();
  return {
    title: 'Run queue',
    size: 'middle',
    body: h('div.stack', h('p.muted', 'Drag a waiting run, or move it with Alt and an arrow key.'), statusText, list, emptyElement),
    footer: [h('span.grow'), h('button.btn', { onclick: close }, 'Close')],
    update(state) {
      const changed = videos !== undefined && (state.videos !== videos || state.runs !== knownRuns);
      [videos, knownRuns] = [state.videos, state.runs];
      if (changed) reloadTimer ??= setTimeout(load, RELOAD_DELAY_MS);
    },
  };
}
