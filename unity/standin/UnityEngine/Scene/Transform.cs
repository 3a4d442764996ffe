using System;
using System.Collections;
using System.Collections.Generic;
using System.Linq;

namespace UnityEngine
{
    public enum Space { World, Self }

    public class Transform : Component, IEnumerable
    {
        protected Transform() { }
        /// What it hangs from.
        internal Transform above;
        readonly List<Transform> down = new List<Transform>();
        Vector3 position0, scale0 = Vector3.one;
        Quaternion rotation0 = Quaternion.identity;

        public bool hasChanged { get; set; } = true;
        void Changed() { hasChanged = true; foreach (var child in down) child.Changed(); }
        void Main(string member) { StandIn.Threads.Main(member); Alive(); }

        public Vector3 localPosition { get { Main("get_localPosition"); return position0; } set { Main("set_localPosition"); position0 = value; Changed(); } }
        public Quaternion localRotation { get { Main("get_localRotation"); return rotation0; } set { Main("set_localRotation"); rotation0 = value.normalized; Changed(); } }
        public Vector3 localScale { get { Main("get_localScale"); return scale0; } set { Main("set_localScale"); scale0 = value; Changed(); } }
        public Vector3 localEulerAngles { get => localRotation.eulerAngles; set => localRotation = Quaternion.Euler(value); }
        public Vector3 position
        {
            get { Main("get_position"); return localToWorldMatrix.GetPosition(); }
            set { Main("set_position"); localPosition = above is null ? value : above.InverseTransformPoint(value); }
        }
        public Quaternion rotation
        {
            get { Main("get_rotation"); return above is null ? rotation0 : above.rotation * rotation0; }
            set { Main("set_rotation"); localRotation = above is null ? value : Quaternion.Inverse(above.rotation) * value; }
        }
        public Vector3 eulerAngles { get => rotation.eulerAngles; set => rotation = Quaternion.Euler(value); }
        public Vector3 lossyScale
        {
            get
            {
                Main("get_lossyScale");
                var m = Matrix4x4.Rotate(Quaternion.Inverse(rotation)) * localToWorldMatrix;
                return new Vector3(m.m00, m.m11, m.m22);
            }
        }
        public Vector3 forward { get => rotation * Vector3.forward; set => rotation = Quaternion.LookRotation(value); }
        public Vector3 up { get => rotation * Vector3.up; set => rotation = Quaternion.FromToRotation(Vector3.up, value); }
        public Vector3 right { get => rotation * Vector3.right; set => rotation = Quaternion.FromToRotation(Vector3.right, value); }
        public Matrix4x4 localToWorldMatrix
        {
            get
            {
                Main("get_localToWorldMatrix");
                var own = Matrix4x4.TRS(position0, rotation0, scale0);
                return above is null ? own : above.localToWorldMatrix * own;
            }
        }
        public Matrix4x4 worldToLocalMatrix => localToWorldMatrix.inverse;
        public void SetPositionAndRotation(Vector3 position, Quaternion rotation) { this.position = position; this.rotation = rotation; }
        public void SetLocalPositionAndRotation(Vector3 localPosition, Quaternion localRotation) { this.localPosition = localPosition; this.localRotation = localRotation; }
        public Vector3 TransformPoint(Vector3 position) => localToWorldMatrix.MultiplyPoint3x4(position);
        public Vector3 InverseTransformPoint(Vector3 position) => worldToLocalMatrix.MultiplyPoint3x4(position);
        public Vector3 TransformVector(Vector3 vector) => localToWorldMatrix.MultiplyVector(vector);
        public Vector3 InverseTransformVector(Vector3 vector) => worldToLocalMatrix.MultiplyVector(vector);
        public Vector3 TransformDirection(Vector3 direction) => rotation * direction;
        public Vector3 InverseTransformDirection(Vector3 direction) => Quaternion.Inverse(rotation) * direction;
        public void Translate(Vector3 translation) => Translate(translation, Space.Self);
        public void Translate(Vector3 translation, Space relativeTo) => position += relativeTo == Space.World ? translation : TransformDirection(translation);
        public void Rotate(Vector3 eulers) => localRotation *= Quaternion.Euler(eulers);
        public void Rotate(float xAngle, float yAngle, float zAngle) => Rotate(new Vector3(xAngle, yAngle, zAngle));
        public void Rotate(Vector3 axis, float angle) => localRotation *= Quaternion.AngleAxis(angle, axis);
        public void RotateAround(Vector3 point, Vector3 axis, float angle) { var by = Quaternion.AngleAxis(angle, axis); position = point + by * (position - point); rotation = by * rotation; }
        public void LookAt(Vector3 worldPosition) => LookAt(worldPosition, Vector3.up);
        public void LookAt(Vector3 worldPosition, Vector3 worldUp) => rotation = Quaternion.LookRotation(worldPosition - position, worldUp);
        public void LookAt(Transform target) => LookAt(target.position);

        public Transform parent { get { Main("get_parent"); return above; } set => SetParent(value, true); }
        public Transform root { get { var at = this; while (!(at.above is null)) at = at.above; return at; } }
        public void SetParent(Transform p) => SetParent(p, true);
        public void SetParent(Transform parent, bool worldPositionStays)
        {
            Main("SetParent");
            if (parent == null) parent = null;
            if (parent == above) return;
            for (var at = parent; !(at is null); at = at.above) if (at == this) return;
            Vector3 position = this.position, scale = lossyScale;
            var rotation = this.rotation;
            above?.down.Remove(this);
            above = parent;
            above?.down.Add(this);
            if (worldPositionStays)
            {
                this.rotation = rotation;
                this.position = position;
                var now = lossyScale;
                scale0 = new Vector3(scale0.x * Ratio(scale.x, now.x), scale0.y * Ratio(scale.y, now.y), scale0.z * Ratio(scale.z, now.z));
            }
            Changed();
            StandIn.Lifecycle.Refresh(owner);
            // Those below it are told, too: an indirect parent of theirs is another.
            if (owner.components.Contains(this))
                foreach (var at in WithChildren().ToArray())
                    foreach (var component in at.owner.components.ToArray()) StandIn.Messages.Send(component, "OnTransformParentChanged");
        }
        static float Ratio(float a, float b) => b == 0 ? 1 : a / b;
        public int childCount => down.Count;
        public Transform GetChild(int index) => index >= 0 && index < down.Count ? down[index] : throw new UnityException("Transform child out of bounds");
        public int GetSiblingIndex() => above is null ? 0 : above.down.IndexOf(this);
        public void SetSiblingIndex(int index) { if (above is null) return; above.down.Remove(this); above.down.Insert(Mathf.Clamp(index, 0, above.down.Count), this); }
        public void DetachChildren() { foreach (var child in Children()) child.SetParent(null); }
        public bool IsChildOf(Transform parent) { for (var at = this; !(at is null); at = at.above) if (at == parent) return true; return false; }
        public Transform Find(string n)
        {
            var at = this;
            foreach (var part in n.Split('/')) { at = at.down.FirstOrDefault(child => child.owner.label == part); if (at is null) return null; }
            return at;
        }
        public IEnumerator GetEnumerator() => down.GetEnumerator();
        internal Transform[] Children() => down.ToArray();
        internal IEnumerable<Transform> WithChildren() { yield return this; foreach (var child in down) foreach (var below in child.WithChildren()) yield return below; }
        internal override void OnDestroyed() { above?.down.Remove(this); above = null; }
    }
}
