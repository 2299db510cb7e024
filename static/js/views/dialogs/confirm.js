// @ts-check
/** A confirmation that says what is removed and what stays. */

import { errorMessage } from '../../api/errors.js';
import { h, setText } from '../dom.js';
import { toast } from '../../core/toast.js';

/** @type {import('./index.js').CreateDialog<'confirm'>} */
export function confirmDialog({ data, close, signal }) {
  const errorText = h('p.field-error', { role: 'alert', hidden: true });
  const cancelButton = h('button.btn', { onclick: close }, 'Cancel');
  const confirmButton = h(
    'button',
    { class: data.danger ? 'btn btn-danger' : 'btn btn-primary', onclick: runAction },
    data.confirm ?? 'OK',
  );

  async function runAction() {
    confirmButton.disabled = true;
    try {
      await data.run();
      if (!signal.aborted) close();
    } catch (thrown) {
      confirmButton.disabled = false;
      errorText.hidden = false;
      setText(errorText, errorMessage(thrown));
      // the action goes on after its dialog is closed
      if (signal.aborted) toast(errorMessage(thrown), { tone: 'bad' });
    }
  }

  return {
    title: data.title ?? 'Are you sure?',
    size: 'narrow',
    focus: cancelButton,
    body: h('div.stack', h('p', data.text), data.note && h('p.muted.small', data.note), errorText),
    footer: [cancelButton, confirmButton],
  };
}
