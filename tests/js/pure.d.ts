/** For `tsconfig.pure.json`: pure code hands a file that somebody chose on to a dialog, and reads nothing of it. */
interface File {
  readonly name: string;
}
