// @ts-check
/** The signed-in person, and the sign-out button. Hidden in a library of one user. */

import { fill, h } from './dom.js';
import { icon } from './icons.js';
import { toastErrors } from './toast_errors.js';

/** @type {import('../page-types.js').CreatePart} */
export function createPerson(app) {
  const element = h('div.row.topbar-person', { hidden: true });
  /** @type {import('../types.js').Session['person']} */ let shownPerson = null;

  const signOut = () =>
    toastErrors(async () => {
      await app.api.signOut();
      location.assign('/sign-in');
    });

  return {
    element,
    update({ session }) {
      const person = session?.person ?? null;
      if (person === shownPerson) return;
      shownPerson = person;
      element.hidden = person === null;
      if (person === null) return;
      fill(
        element,
        h(
          'a.nav-link',
          { href: `#/team/${encodeURIComponent(person.name)}`, title: `${person.name}, ${person.role}: your activity` },
          h('span.topbar-name.truncate', { dir: 'auto' }, person.name),
        ),
        person.can_sign_out &&
          h(
            'button.btn.btn-quiet.btn-icon',
            { title: `Sign out ${person.name}`, 'aria-label': 'Sign out', onclick: () => void signOut() },
            icon('leave'),
          ),
      );
    },
  };
}
