// What the bundler puts in as text: the udev rule, and what the documents say of faults.
declare module "*.rules" {
  const text: string;
  export default text;
}
declare module "*.md" {
  const text: string;
  export default text;
}
