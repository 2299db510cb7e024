// @ts-check
/** The end of the queue: the open tracks in the rest of the library, and a button to the next video. */

import { openVideos, reviewedMessage } from '../../model/open_videos.js';
import { NEXT_VIDEO_KEY } from '../../operations/next_video.js';
import { h, setText } from '../dom.js';
import { icon } from '../icons.js';

/** @param {() => void} next   opens the next video */
export function createQueueEnd(next) {
  const text = h('p', { role: 'status' });
  const name = h('span.truncate');
  const button = h('button.btn.btn-small.btn-primary', { onclick: next }, icon('film'), h('span', 'Next video'));
  const element = h('div.queue-end', { hidden: true }, text, h('div.queue-end-next', button, name));
  return {
    element,
    /**
     * @param {import('../../state-types.js').State} state
     * @param {import('../../model/queue.js').QueueCounts} counts   counts of all tracks, regardless of the filter
     */
    update({ videos, review }, counts) {
      const isRunFinished = review?.tracks && review.run && !['queued', 'running'].includes(review.run.state);
      element.hidden = !isRunFinished || videos === null || counts.left > 0;
      if (!review || element.hidden) return;
      const left = openVideos(videos, review.video.id);
      setText(text, reviewedMessage(left, counts.total));
      button.hidden = name.hidden = left.next === null;
      button.title = `Next video with open tracks (${NEXT_VIDEO_KEY})`;
      setText(name, left.next?.name ?? '');
      name.title = left.next?.name ?? '';
    },
  };
}
