// @ts-check
/** Return an assignment to its person, with a comment. */

import { h } from '../dom.js';
import { changeAssignment } from '../assignment_strip.js';
import { field } from './fields.js';

/** @type {import('./index.js').CreateDialog<'return-work'>} */
export function returnWorkDialog({ app, data, close }) {
  const { assignment } = data;
  const commentInput = h('textarea.textarea', { id: 'return-comment', rows: '4', maxlength: 2000, required: true });
  return {
    title: `Return the work to ${assignment.person}`,
    size: 'narrow',
    focus: commentInput,
    body: h('div.stack', field('What to do again', commentInput, `${assignment.person} sees this above the picture.`)),
    footer: [h('span.grow'), h('button.btn', { onclick: close }, 'Cancel'), h('button.btn.btn-primary', { type: 'submit' }, 'Return')],
    submit() {
      const text = commentInput.value.trim();
      if (text === '') return commentInput.focus();
      close();
      void changeAssignment(app, assignment, { state: 'returned', comment: text }, `The work was returned to ${assignment.person}.`);
    },
  };
}
