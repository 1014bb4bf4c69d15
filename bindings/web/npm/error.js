// An error of the library: one line that says what is wrong and what to do.
export class KneadError extends Error {
  constructor(message) {
    super(message);
    this.name = 'KneadError';
  }
}
