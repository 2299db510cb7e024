// @ts-check
/** A confirmation that says what is removed and what stays. */

import { sentence } from '../../api/errors.js';
import { h, setText } from '../dom.js';

/**
 * @param {import('./index.js').DialogSetup<'confirm'>} setup
 * @returns {import('./index.js').DialogContent}
 */
export function confirmDialog({ data, close, signal }) {
  const error = h('p.field-error', { role: 'alert', hidden: true });
  const cancel = h('button.btn', { onclick: close }, 'Cancel');
  const go = h('button', { class: data.danger ? 'btn btn-danger' : 'btn btn-primary', onclick: act }, data.confirm ?? 'OK');

  async function act() {
    go.disabled = true;
    try {
      await data.run();
      if (!signal.aborted) close();
    } catch (thrown) {
      go.disabled = false;
      error.hidden = false;
      setText(error, sentence(thrown));
    }
  }

  return {
    title: data.title ?? 'Are you sure?',
    size: 'narrow',
    focus: cancel,
    body: h('div.stack', h('p', data.text), data.note && h('p.muted.small', data.note), error),
    footer: [cancel, go],
  };
}
