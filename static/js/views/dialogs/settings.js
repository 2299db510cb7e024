// @ts-check
/** Preferences of this browser: the author's name of edits, and the theme. */

import { setTheme } from '../../store/actions/page.js';
import { h, selectInput } from '../dom.js';
import { forget, recall, remember } from '../../core/preferences.js';
import { toast } from '../../core/toast.js';
import { field, textInput } from './fields.js';

const THEMES = /** @type {const} */ ([
  ['auto', 'same as the system'],
  ['light', 'light'],
  ['dark', 'dark'],
]);

/** @type {import('./index.js').CreateDialog<'settings'>} */
export function settingsDialog({ app, close }) {
  const { session, theme: currentTheme } = app.store.get();
  const authorInput = textInput('settings-author', {
    maxlength: 80,
    autocomplete: 'name',
    value: recall('author') ?? '',
    placeholder: session?.author ?? '',
  });
  const themeSelect = selectInput({ id: 'settings-theme' }, THEMES, currentTheme);

  function submit() {
    app.store.dispatch(setTheme, /** @type {'auto'|'light'|'dark'} */ (themeSelect.value));
    close();
    if (session?.person) return;
    const name = authorInput.value.replaceAll(/[\u0000-\u001f\u007f]/g, '').trim();
    if (name) remember('author', name);
    else forget('author');
    if (app.store.get().review) void app.editor.refresh();
    toast(`Your changes are saved under the name “${name || session?.author || 'someone'}”.`, { tone: 'good' });
  }

  return {
    title: 'Preferences',
    size: 'narrow',
    submit,
    focus: session?.person ? themeSelect : authorInput,
    body: h(
      'div.stack',
      session?.person
        ? h('p.small', `You are signed in as ${session.person.name}. Your changes are saved under that name.`)
        : field(
            'Your name',
            authorInput,
            'The author of your corrections and notes from now on. Undo reverts only changes under this name. Empty: the server’s default.',
          ),
      field('Theme', themeSelect),
    ),
    footer: [h('span.grow'), h('button.btn', { onclick: close }, 'Cancel'), h('button.btn.btn-primary', { type: 'submit' }, 'Save')],
  };
}
