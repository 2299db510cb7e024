// @ts-check
/** What the dragged tau would turn over in the whole drive: says it, and leads from track to track. */

import { flippedPlaces, nextPlace } from '../../model/drive_flips.js';
import { seek, select } from '../app.js';
import { h, setText } from '../dom.js';
import { createFollower } from '../follower.js';
import { count, plural } from '../format.js';

/** @typedef {import('../../types.js').Flips} Flips */
/** @typedef {{run: string, tau: number}} Question */

/** @param {import('../app.js').ViewApp} app @param {AbortSignal} signal */
export function createDriveFlips(app, signal) {
  const element = h('button', { class: 'btn btn-small btn-quiet lanes-drive-flips', type: 'button', hidden: true });
  /** @type {Question|null} */ let asked = null;
  /** @type {{question: Question, flips: Flips}|null} */ let found = null;

  /** @param {Question} question */
  const ask = async (question) => {
    const flips = await app.api.flips(question.run, question.tau, { signal });
    if (asked === question) tell({ question, flips });
  };
  const follower = createFollower(ask, {
    pause: 120,
    failed: (thrown) => {
      if (signal.aborted || asked === null) return;
      found = null;
      setText(element, 'Drive: not counted');
      element.title = thrown instanceof Error ? thrown.message : 'The server did not answer. Drag tau once more.';
      element.disabled = true;
    },
  });
  signal.addEventListener('abort', () => follower.stop(), { once: true });

  /** @param {{question: Question, flips: Flips}} answer */
  function tell(answer) {
    found = answer;
    const { flips } = answer;
    const turned = flips.to_confident + flips.to_rejected;
    setText(element, turned === 0
      ? `Drive: none of ${plural(flips.verdicts, 'verdict')} flips`
      : `Drive: ${count(turned)} of ${plural(flips.verdicts, 'verdict')} flip in ${plural(flips.tracks.length, 'track')}`);
    element.title = turned === 0
      ? 'No verdict of the gate would be another one'
      : `${plural(flips.to_confident, 'rejection')} would become confident, ${plural(flips.to_rejected, 'confident verdict')} would be rejected. Click: the next track with one`;
    element.disabled = turned === 0;
  }

  element.addEventListener('click', () => {
    const { review } = app.store.get();
    if (review === null || found === null) return;
    const place = nextPlace(flippedPlaces(found.flips, review.docs), review.selected, review.frame);
    if (place === null) return;
    select(app, place.key);
    seek(app, place.frame);
  }, { signal });

  return {
    element,
    /** @param {string|undefined} run @param {number|null} tau   null: the run's own, which turns nothing over */
    update(run, tau) {
      if (run === undefined || tau === null) {
        asked = found = null;
        element.hidden = true;
        return;
      }
      if (asked !== null && asked.run === run && asked.tau === tau) return;
      if (asked === null) {
        setText(element, 'Drive: counting…');
        element.title = '';
        element.disabled = true;
      }
      asked = { run, tau };
      element.hidden = false;
      follower.push(asked);
    },
  };
}
