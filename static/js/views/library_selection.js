// @ts-check
/** Selection of videos in the library, and actions on all selected videos. */

import { openDialog } from '../store/actions/page.js';
import { h, setText } from './dom.js';
import { count, plural } from '../model/format.js';
import { icon } from './icons.js';

/** @typedef {import('../types.js').Video} Video */

/**
 * @param {Pick<import('../page-types.js').App, 'store'>} app
 * @param {() => void} onChange   redraws the cards
 */
export function createSelection({ store }, onChange) {
  /** @type {Set<string>} */ const selectedIds = new Set();
  /** @type {readonly Video[]} */ let shown = [];
  /** Id of the video at which a range begins. @type {string|null} */
  let anchor = null;
  const countText = h('strong', { role: 'status' });
  const runLabel = h('span');
  const runButton = h(
    'button.btn.btn-primary',
    {
      onclick: () => {
        store.dispatch(openDialog, { kind: 'run-several', data: { videos: runnableVideos(), done: deselect } });
      },
    },
    icon('run'),
    runLabel,
  );
  const selectAllButton = h('button.btn', {
    onclick: () =>
      setSelected(
        shown.map(({ id }) => id),
        true,
      ),
  });
  const deselectAllButton = h('button.btn.btn-quiet', { onclick: () => setSelected([...selectedIds], false) }, 'Choose none');
  const element = h('div.library-chosen', { hidden: true }, countText, h('span.grow'), selectAllButton, deselectAllButton, runButton);

  /** Selected videos on which the engine can run, in screen order. */
  const runnableVideos = () =>
    [...new Map([...shown, ...(store.get().videos ?? [])].map((video) => [video.id, video])).values()].filter(
      ({ id, state, missing }) => selectedIds.has(id) && state === 'ready' && !missing,
    );

  /** @param {readonly string[]} ids */
  const deselect = (ids) => setSelected(ids, false);

  /** @param {readonly string[]} ids @param {boolean} on */
  function setSelected(ids, on) {
    for (const id of ids)
      if (on) selectedIds.add(id);
      else selectedIds.delete(id);
    draw();
    onChange();
  }

  function draw() {
    const hiddenCount = selectedIds.size - shown.filter(({ id }) => selectedIds.has(id)).length;
    const runnableCount = runnableVideos().length;
    element.hidden = selectedIds.size === 0;
    setText(countText, `${plural(selectedIds.size, 'video')} chosen${hiddenCount ? `, ${count(hiddenCount)} of them not shown` : ''}`);
    setText(selectAllButton, `Choose all ${count(shown.length)} shown`);
    selectAllButton.hidden = shown.every(({ id }) => selectedIds.has(id));
    setText(runLabel, `Run the engine on ${count(runnableCount)}`);
    runButton.disabled = runnableCount === 0;
    runButton.title =
      runnableCount === selectedIds.size
        ? 'One run for each of them, with the same settings'
        : `${plural(selectedIds.size - runnableCount, 'video')} cannot be run: not imported, or the file is missing`;
  }

  return {
    element,
    /** @param {string} id */
    has: (id) => selectedIds.has(id),
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
      setSelected(range && from >= 0 && to >= 0 ? ids.slice(Math.min(from, to), Math.max(from, to) + 1) : [id], on);
      anchor = id;
    },
    /**
     * @param {readonly Video[]} found    the shown videos
     * @param {readonly Video[]} videos   all videos of the library
     */
    show(found, videos) {
      shown = found;
      if (selectedIds.size > 0) {
        const existingIds = new Set(videos.map(({ id }) => id));
        for (const id of selectedIds) if (!existingIds.has(id)) selectedIds.delete(id);
      }
      draw();
    },
  };
}
