/** Rules that find errors; prettier decides the format. */

import js from '@eslint/js';
import globals from 'globals';

export default [
  { ignores: ['**/*', '!static/', '!static/js/', '!static/js/**', '!tests/', '!tests/js/', '!tests/js/**', '!*.js'] },
  js.configs.recommended,
  {
    files: ['static/js/**/*.js', 'tests/js/**/*.js'],
    languageOptions: { ecmaVersion: 2024, sourceType: 'module', globals: { ...globals.browser } },
    linterOptions: { reportUnusedDisableDirectives: 'error' },
    rules: {
      'array-callback-return': ['error', { checkForEach: false }],
      eqeqeq: ['error', 'always', { null: 'ignore' }],
      'no-constructor-return': 'error',
      'no-implicit-globals': 'error',
      'no-template-curly-in-string': 'error',
      'no-unreachable-loop': 'error',
      'no-unused-vars': ['error', { varsIgnorePattern: '^_', argsIgnorePattern: '^_', caughtErrors: 'all' }],
      'no-use-before-define': ['error', { functions: false, classes: true, variables: false }],
      'no-useless-assignment': 'error',
      'no-var': 'error',
      'prefer-const': 'error',
      'no-restricted-properties': [
        'error',
        // they exist only on pages from this machine or by HTTPS, and teams open the page by plain HTTP too
        { object: 'crypto', property: 'randomUUID', message: 'Use randomId() of core/random_id.js.' },
        { object: 'crypto', property: 'subtle' },
        { object: 'navigator', property: 'clipboard' },
      ],
      'no-control-regex': 'off', // names of people are checked for control characters
      'max-lines': ['error', 350],
    },
  },
  { files: ['tests/js/**/*.js'], languageOptions: { globals: { ...globals.browser, ...globals.node } }, rules: { 'max-lines': 'off' } },
];
