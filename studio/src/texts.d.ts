// Text from the bundler: the udev rule, and the documents' entries about faults.
declare module "*.rules" {
  const text: string;
  export default text;
}
declare module "*.md" {
  const text: string;
  export default text;
}
