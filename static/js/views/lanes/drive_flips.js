// @ts-check
/**
 * The verdicts in the whole drive that flip at the dragged tau: their number, and a button that goes from track to
 * track.
 */

import { flippedTracks, nextFlippedTrack } from '../../model/drive_flips.js';
import { seek, select } from '../app.js';
import { h, setText } from '../dom.js';
import { createFollower } from '../follower.js';
import { plural } from '../../model/format.js';

/** @typedef {import('../../types.js').Flips} Flips */
/** @typedef {{run: string, tau: number}} Question */

/** @param {import('../app.js').ViewApp} app @param {AbortSignal} signal */
export function createDriveFlips(app, signal) {
  const element = h('button.btn.btn-small.btn-quiet.lanes-drive-flips', { hidden: true });
  /** @type {Question|null} */ let asked = null;
  /** @type {Flips|null} */ let found = null;
  /** @type {readonly import('../../model/drive_flips.js').FlippedTrack[]} */ let places = [];
  /** @type {Record<string, unknown>|null} */ let docs = null;

  /** @param {Question} question */
  const ask = async (question) => {
    const flips = await app.api.flips(question.run, question.tau, { signal });
    if (asked !== question) return;
    found = flips;
    tell();
  };
  const follower = createFollower(ask, {
    pause: 120,
    failed: (thrown) => {
      if (signal.aborted || asked === null) return;
      found = null;
      say('Drive: not counted', thrown instanceof Error ? thrown.message : 'The server did not answer. Drag tau again.', false);
    },
  });
  signal.addEventListener('abort', () => follower.stop(), { once: true });

  /** @param {string} text @param {string} title @param {boolean} leads */
  function say(text, title, leads) {
    setText(element, text);
    element.title = title;
    element.disabled = !leads;
  }

  function tell() {
    const { review } = app.store.get();
    if (found === null || review === null) return;
    places = flippedTracks(found, review.docs);
    const turned = places.reduce((sum, { flips }) => sum + flips, 0);
    const all = plural(found.verdicts, 'verdict');
    if (turned === 0) {
      say('Drive: no verdict flips', `None of the run’s ${all} would flip`, false);
      return;
    }
    const tracks = new Set(places.map(({ key }) => key)).size;
    const outcome = found.tau < found.run_tau ? 'be rejected' : 'be confident';
    say(
      `Drive: ${plural(turned, 'verdict flips', 'verdicts flip')} in ${plural(tracks, 'track')}`,
      `They would ${outcome}, of the run’s ${all}. Click: next track with a flip`,
      true,
    );
  }

  element.addEventListener(
    'click',
    () => {
      const { review } = app.store.get();
      const place = review && nextFlippedTrack(places, review.selected, review.frame);
      if (!place) return;
      select(app, place.key);
      seek(app, place.frame);
    },
    { signal },
  );

  return {
    element,
    /** @param {import('../../state-types.js').ReviewState} review   its `tau` is null while it is the run's own, at which nothing flips */
    update({ run, tau, docs: now }) {
      if (run === null || tau === null) {
        asked = found = null;
        element.hidden = true;
        return;
      }
      if (docs !== now) {
        docs = now;
        tell();
      }
      if (asked !== null && asked.run === run.id && asked.tau === tau) return;
      if (asked === null) say('Drive: counting…', '', false);
      asked = { run: run.id, tau };
      element.hidden = false;
      follower.push(asked);
    },
  };
}
