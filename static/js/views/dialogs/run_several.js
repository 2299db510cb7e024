// @ts-check
/** Start a run on each of several videos with the same settings. */

import { errorMessage } from '../../api/errors.js';
import { processAll } from '../../model/several_videos.js';
import { putRun } from '../../store/actions/page.js';
import { h, setText } from '../dom.js';
import { count, plural } from '../../model/format.js';
import { toast } from '../../core/toast.js';
import { createRunForm } from './run_form.js';

/** @type {import('./index.js').CreateDialog<'run-several'>} */
export function runSeveralDialog(setup) {
  const { app, data, signal, close } = setup;
  /** @type {readonly import('../../types.js').Video[]} */ const videos = data.videos;
  const progress = h('p.muted', { role: 'status' });

  /** @param {import('../../api/runs.js').RunRequest} request */
  async function send(request) {
    let startedCount = 0;
    const { done: started, errors } = await processAll(
      videos,
      (video) => {
        startedCount += 1;
        setText(progress, `Run ${count(startedCount)} of ${count(videos.length)} is being started …`);
        return app.load(() => app.api.startRun(video.id, request, { signal }), putRun);
      },
      errorMessage,
    );
    setText(progress, '');
    if (started.length) toast(`${plural(started.length, 'run')} ${started.length === 1 ? 'is' : 'are'} started.`, { tone: 'good' });
    data.done?.(started.map(({ video_id }) => video_id));
    if (signal.aborted) return '';
    if (started.length === 0) return errors[0] ?? '';
    if (errors.length) toast(joinErrors(errors), { tone: 'bad' });
    close();
    return '';
  }

  const form = createRunForm(setup, { frames: null, several: true, buttonText: 'Start the runs', send });
  return {
    title: `Run the engine on ${plural(videos.length, 'video')}`,
    size: 'middle',
    body: h(
      'div.stack',
      h('p', 'Each video gets a run with this preset and these parameters. The runs are queued; “Run queue” changes their order.'),
      form.element,
      progress,
    ),
    footer: form.footer,
    submit: form.submit,
    focus: form.focus,
  };
}

/** Maximum number of sentences in one notice. */
const MAX_MESSAGES = 3;

/** @param {readonly string[]} errors */
function joinErrors(errors) {
  const distinct = [...new Set(errors)];
  const hiddenCount = distinct.length - MAX_MESSAGES;
  return [...distinct.slice(0, MAX_MESSAGES), ...(hiddenCount > 0 ? [`And ${plural(hiddenCount, 'other problem')}.`] : [])].join(' ');
}
