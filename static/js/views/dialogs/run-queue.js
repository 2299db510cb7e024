// @ts-check
/** Runs in progress or waiting for a worker. Waiting runs can be reordered by drag or keyboard. */

import { sentence } from '../../api/errors.js';
import { runShare } from '../../model/run_progress.js';
import { changeRun } from '../change_run.js';
import { h, reconcile, setText } from '../dom.js';
import { emptyState } from '../empty.js';
import { count, plural } from '../../model/format.js';
import { icon } from '../icons.js';
import { createMeter, setMeter } from '../meter.js';
import { runKind, runProgress } from '../../model/describe_run.js';
import { toast } from '../../core/toast.js';

/** @typedef {import('../../types.js').Run} Run */

/** Interval of reloads while the queue changes, ms. */
const PAUSE = 1000;

/**
 * @param {import('./layer.js').Setup<'run-queue'>} setup
 * @returns {import('./layer.js').Content}
 */
export function runQueueDialog({ app, close, signal }) {
  const list = h('ol.line', { 'aria-label': 'Runs in queue order' });
  const told = h('p.muted.small', { role: 'status' });
  const none = h(
    'div',
    { hidden: true },
    emptyState({ icon: 'run', title: 'No run waits', text: 'Started runs are listed here until a worker has finished them.' }),
  );
  /** @type {Run[]} */
  let runs = [];
  /** @type {string|null} */
  let dragged = null;
  /** @type {readonly import('../../types.js').Video[]|null|undefined} */
  let videos;
  /** @type {Record<string, Run[]>|undefined} */
  let known;
  /** @type {ReturnType<typeof setTimeout>|undefined} */
  let waiting;
  let asked = 0;
  signal.addEventListener('abort', () => clearTimeout(waiting));

  async function load() {
    waiting = undefined;
    const mine = ++asked;
    try {
      const found = await app.api.runQueue({ signal });
      if (mine !== asked) return; // a later request has overtaken this answer
      runs = found;
      draw();
    } catch (thrown) {
      if (!signal.aborted) setText(told, sentence(thrown));
    }
  }

  function draw() {
    const names = new Map((app.store.get().videos ?? []).map(({ id, name }) => [id, name]));
    const waits = runs.filter(({ state }) => state === 'queued');
    const held = document.activeElement;
    reconcile(
      list,
      runs,
      ({ id }) => id,
      row,
      (item, run) => show(item, run, names.get(run.video_id) ?? 'A video', waits),
    );
    // an element that is moved in the page loses the focus
    if (held instanceof HTMLElement && list.contains(held)) held.focus();
    none.hidden = runs.length > 0;
    setText(told, runs.length === 0 ? '' : `${plural(runs.length - waits.length, 'run')} in progress, ${count(waits.length)} waiting.`);
  }

  /** @param {Run} run */
  function row(run) {
    /** @param {number} by */
    const button = (by) =>
      h(
        'button.btn.btn-small.btn-quiet.btn-icon',
        { dataset: { by: String(by) }, onclick: () => step(run.id, by) },
        icon(by < 0 ? 'up' : 'down'),
      );
    return h(
      'li.line-run',
      {
        draggable: 'false',
        tabIndex: -1,
        onkeydown: (/** @type {KeyboardEvent} */ event) => {
          const by = event.altKey ? { ArrowUp: -1, ArrowDown: 1 }[event.key] : undefined;
          if (by === undefined) return;
          event.preventDefault();
          step(run.id, by);
        },
        ondragstart: (/** @type {DragEvent} */ event) => {
          dragged = run.id;
          event.dataTransfer?.setData('text/plain', run.id);
        },
        ondragend: () => {
          dragged = null;
          mark(null, false);
        },
        ondragover: (/** @type {DragEvent} */ event) => {
          if (dragged === null || !isWaiting(run.id)) return;
          event.preventDefault();
          mark(/** @type {HTMLElement} */ (event.currentTarget), isLower(event));
        },
        ondrop: (/** @type {DragEvent} */ event) => {
          event.preventDefault();
          if (dragged !== null) void move(dragged, isLower(event) ? after(run.id, 1) : run.id);
        },
      },
      h('span.line-grip', { 'aria-hidden': 'true' }, '⠿'),
      h('span.line-words', h('strong.truncate.line-name'), h('span.muted.small.line-facts'), createMeter('Run')),
      button(-1),
      button(1),
      h(
        'button.btn.btn-small.line-cancel',
        { onclick: () => changeRun(app, () => app.api.cancelRun(run.id), signal).then(load) },
        'Cancel',
      ),
    );
  }

  /** @param {HTMLElement} item @param {Run} run @param {string} video @param {readonly Run[]} waits */
  function show(item, run, video, waits) {
    const at = waits.findIndex(({ id }) => id === run.id);
    item.draggable = at >= 0;
    item.classList.toggle('line-waits', at >= 0);
    setText(/** @type {HTMLElement} */ (item.querySelector('.line-name')), video);
    setText(
      /** @type {HTMLElement} */ (item.querySelector('.line-facts')),
      [run.name || runKind(run), at < 0 ? runProgress(run) : `${count(at + 1)}. in the queue`].join(' · '),
    );
    const meter = /** @type {HTMLElement} */ (item.querySelector('.meter'));
    meter.hidden = at >= 0;
    setMeter(meter, runShare(run));
    for (const button of /** @type {NodeListOf<HTMLButtonElement>} */ (item.querySelectorAll('[data-by]'))) {
      const up = button.dataset.by === '-1';
      button.hidden = at < 0;
      // not disabled, because the focus would be lost between steps
      button.setAttribute('aria-disabled', String(up ? at === 0 : at === waits.length - 1));
      button.title = up ? 'Earlier (Alt+↑)' : 'Later (Alt+↓)';
      button.setAttribute('aria-label', `${video}: ${up ? 'earlier' : 'later'}`);
    }
    /** @type {HTMLElement} */ (item.querySelector('.line-cancel')).setAttribute('aria-label', `Cancel the run of ${video}`);
  }

  /** Ids of waiting runs, in order. */
  const line = () => runs.filter(({ state }) => state === 'queued').map(({ id }) => id);

  /** The waiting run `by` places after another one; null: the end. @param {string} id @param {number} by */
  const after = (id, by) => line()[line().indexOf(id) + by] ?? null;

  /** @param {string} id */
  const isWaiting = (id) => line().includes(id);

  /** @param {DragEvent} event   over a row */
  const isLower = (event) => {
    const { top, height } = /** @type {HTMLElement} */ (event.currentTarget).getBoundingClientRect();
    return event.clientY > top + height / 2;
  };

  /** @param {HTMLElement|null} item @param {boolean} lower */
  function mark(item, lower) {
    for (const other of list.children) {
      other.classList.toggle('line-above', other === item && !lower);
      other.classList.toggle('line-below', other === item && lower);
    }
  }

  /** @param {string} id @param {number} by */
  function step(id, by) {
    const place = line().indexOf(id);
    if (place < 0 || !line()[place + by]) return;
    void move(id, after(id, by < 0 ? -1 : 2));
  }

  /** @param {string} id @param {string|null} before */
  async function move(id, before) {
    if (id === before) return;
    try {
      await app.api.moveRun(id, before, { signal });
    } catch (thrown) {
      if (!signal.aborted) toast(sentence(thrown), { tone: 'bad' });
    }
    await load();
  }

  void load();
  return {
    title: 'Run queue',
    size: 'middle',
    body: h('div.stack', h('p.muted', 'Drag a waiting run, or move it with Alt and an arrow key.'), told, list, none),
    footer: [h('span.grow'), h('button.btn', { onclick: close }, 'Close')],
    update(state) {
      const changed = videos !== undefined && (state.videos !== videos || state.runs !== known);
      [videos, known] = [state.videos, state.runs];
      if (changed) waiting ??= setTimeout(load, PAUSE);
    },
  };
}
