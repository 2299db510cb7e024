// @ts-check
/** Selection of videos in the library, and actions on all selected videos. */

import { openDialog } from '../store/actions/page.js';
import { h, setText } from './dom.js';
import { count, plural } from '../model/format.js';
import { icon } from './icons.js';

/** @typedef {import('../types.js').Video} Video */

/**
 * @param {Pick<import('../page-types.js').App, 'store'>} app
 * @param {() => void} changed   redraws the cards
 */
export function createSelection({ store }, changed) {
  /** @type {Set<string>} */
  const chosen = new Set();
  /** @type {readonly Video[]} */
  let shown = [];
  /** Id of the video at which a range begins. @type {string|null} */
  let anchor = null;
  const words = h('strong', { role: 'status' });
  const runWords = h('span');
  const run = h(
    'button.btn.btn-primary',
    {
      onclick: () => {
        store.dispatch(openDialog, { kind: 'run-several', data: { videos: ready(), done: drop } });
      },
    },
    icon('run'),
    runWords,
  );
  const all = h('button.btn', {
    onclick: () =>
      set(
        shown.map(({ id }) => id),
        true,
      ),
  });
  const none = h('button.btn.btn-quiet', { onclick: () => set([...chosen], false) }, 'Choose none');
  const element = h('div.library-chosen', { hidden: true }, words, h('span.grow'), all, none, run);

  /** Selected videos on which the engine can run, in screen order. */
  const ready = () =>
    [...new Map([...shown, ...(store.get().videos ?? [])].map((video) => [video.id, video])).values()].filter(
      ({ id, state, missing }) => chosen.has(id) && state === 'ready' && !missing,
    );

  /** @param {readonly string[]} ids */
  const drop = (ids) => set(ids, false);

  /** @param {readonly string[]} ids @param {boolean} on */
  function set(ids, on) {
    for (const id of ids)
      if (on) chosen.add(id);
      else chosen.delete(id);
    draw();
    changed();
  }

  function draw() {
    const hidden = chosen.size - shown.filter(({ id }) => chosen.has(id)).length;
    const usable = ready().length;
    element.hidden = chosen.size === 0;
    setText(words, `${plural(chosen.size, 'video')} chosen${hidden ? `, ${count(hidden)} of them not shown` : ''}`);
    setText(all, `Choose all ${count(shown.length)} shown`);
    all.hidden = shown.every(({ id }) => chosen.has(id));
    setText(runWords, `Run the engine on ${count(usable)}`);
    run.disabled = usable === 0;
    run.title =
      usable === chosen.size
        ? 'One run for each of them, with the same settings'
        : `${plural(chosen.size - usable, 'video')} cannot be run: not imported, or the file is missing`;
  }

  return {
    element,
    /** @param {string} id */
    has: (id) => chosen.has(id),
    /** Whether any video is selected. */
    any: () => chosen.size > 0,
    /**
     * Select or deselect a video; with a range, all since the last one.
     *
     * @param {string} id
     * @param {boolean} on
     * @param {boolean} range
     */
    choose(id, on, range) {
      const ids = shown.map((video) => video.id);
      const [from, to] = [ids.indexOf(anchor ?? id), ids.indexOf(id)];
      set(range && from >= 0 && to >= 0 ? ids.slice(Math.min(from, to), Math.max(from, to) + 1) : [id], on);
      anchor = id;
    },
    /**
     * @param {readonly Video[]} found    the shown videos
     * @param {readonly Video[]} videos   all videos of the library
     */
    show(found, videos) {
      shown = found;
      if (chosen.size > 0) {
        const there = new Set(videos.map(({ id }) => id));
        for (const id of chosen) if (!there.has(id)) chosen.delete(id);
      }
      draw();
    },
  };
}
