// The tree of visual elements.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Linq;

namespace UnityEngine.UIElements
{
    public interface IPanel
    {
        VisualElement visualTree { get; }
        FocusController focusController { get; }
    }

    public class FocusController
    {
        internal FocusController() { }
        public Focusable focusedElement { get; internal set; }
        public void IgnoreEvent(EventBase evt) => evt.Ignore();
    }

    public abstract class Focusable : CallbackEventHandler
    {
        public bool focusable { get; set; }
        public int tabIndex { get; set; }
        public abstract FocusController focusController { get; }
        public virtual bool canGrabFocus => focusable;
        public virtual void Focus() { }
        public virtual void Blur() { }
    }

    public interface IVisualElementScheduledItem
    {
        bool isActive { get; }
        void Resume();
        void Pause();
        void ExecuteLater(long delayMs);
        IVisualElementScheduledItem StartingIn(long delayMs);
        IVisualElementScheduledItem Every(long intervalMs);
        IVisualElementScheduledItem Until(Func<bool> stopCondition);
    }

    public interface IVisualElementScheduler
    {
        IVisualElementScheduledItem Execute(Action updateEvent);
    }

    public partial class VisualElement : Focusable
    {
        readonly List<VisualElement> children = new List<VisualElement>();
        readonly List<string> classes = new List<string>();
        VisualElement physicalParent;
        bool isEnabled = true;
        internal StandIn.Panel ownPanel;
        internal bool isDirty = true;

        public VisualElement()
        {
            style = new InlineStyle();
            resolvedStyle = new ResolvedStyle(this);
            schedule = new StandIn.Scheduler(this);
            hierarchy = new Hierarchy(this);
        }

        public struct Hierarchy
        {
            readonly VisualElement owner;
            internal Hierarchy(VisualElement owner) { this.owner = owner; }
            public VisualElement parent => owner.physicalParent;
            public int childCount => owner.children.Count;
            public VisualElement this[int key] => owner.children[key];
            public void Add(VisualElement child) => Insert(owner.children.Count, child);
            public IEnumerable<VisualElement> Children() => owner.children;
            public void Insert(int index, VisualElement child)
            {
                if (child == null) throw new ArgumentException("Cannot insert null child");
                if (child == owner) throw new ArgumentException("Cannot insert element as its own child");
                if (child.physicalParent == owner && index == owner.children.Count) index--;
                child.RemoveFromHierarchy();
                owner.children.Insert(index, child);
                child.physicalParent = owner;
                owner.ownPanel?.Attach(child);
                if (owner.ownPanel != null) owner.ownPanel.needsLayout = true;
            }
            public void Remove(VisualElement child)
            {
                if (child.physicalParent != owner) throw new ArgumentException("This VisualElement is not my child");
                owner.ownPanel?.Detach(child);
                owner.children.Remove(child);
                child.physicalParent = null;
                if (owner.ownPanel != null) owner.ownPanel.needsLayout = true;
            }
        }

        public Hierarchy hierarchy { get; }
        public virtual VisualElement contentContainer => this;
        public string name { get; set; } = "";
        public object userData { get; set; }
        public string tooltip { get; set; }
        public string viewDataKey { get; set; }
        public PickingMode pickingMode { get; set; }
        public bool visible { get => style.visibility.value == Visibility.Visible; set => style.visibility = value ? Visibility.Visible : Visibility.Hidden; }
        public IStyle style { get; }
        public IResolvedStyle resolvedStyle { get; }
        public IVisualElementScheduler schedule { get; }
        public IPanel panel => ownPanel;
        public override FocusController focusController => ownPanel?.focusController;
        public override bool canGrabFocus => focusable && enabledInHierarchy && ownPanel != null && StandIn.Panel.IsShown(this);
        public Rect layout { get; internal set; }
        public Rect localBound => layout;
        public Rect contentRect => new Rect(0, 0, layout.width, layout.height);
        public Rect worldBound
        {
            get
            {
                var at = layout.position;
                for (var above = physicalParent; above != null; above = above.physicalParent) at += above.layout.position;
                return new Rect(at.x, at.y, layout.width, layout.height);
            }
        }
        public float scaledPixelsPerPoint => 1;

        public VisualElement parent
        {
            get
            {
                for (var above = physicalParent; above != null; above = above.physicalParent)
                    if (above.contentContainer == physicalParent) return above;
                return physicalParent;
            }
        }

#if UNITY_6000_0_OR_NEWER
        public bool enabledSelf { get => isEnabled; set => isEnabled = value; }
#else
        public bool enabledSelf => isEnabled;
#endif
        public bool enabledInHierarchy => isEnabled && (physicalParent == null || physicalParent.enabledInHierarchy);
        public void SetEnabled(bool value) => isEnabled = value;

        public int childCount => contentContainer == this ? children.Count : contentContainer.childCount;
        public VisualElement this[int key] => ElementAt(key);
        public VisualElement ElementAt(int index) => contentContainer == this ? children[index] : contentContainer.ElementAt(index);
        public int IndexOf(VisualElement element) => contentContainer == this ? children.IndexOf(element) : contentContainer.IndexOf(element);
        public IEnumerable<VisualElement> Children() => contentContainer == this ? children : contentContainer.Children();
        public void Add(VisualElement child) { if (contentContainer == this) hierarchy.Add(child); else contentContainer.Add(child); }
        public void Insert(int index, VisualElement element) { if (contentContainer == this) hierarchy.Insert(index, element); else contentContainer.Insert(index, element); }
        public void Remove(VisualElement element) { if (contentContainer == this) hierarchy.Remove(element); else contentContainer.Remove(element); }
        public void RemoveAt(int index) => Remove(ElementAt(index));
        public void Clear() { while (childCount > 0) RemoveAt(childCount - 1); }
        public void RemoveFromHierarchy() => physicalParent?.hierarchy.Remove(this);
        public bool Contains(VisualElement child)
        {
            for (var at = child?.physicalParent; at != null; at = at.physicalParent) if (at == this) return true;
            return false;
        }

        public void AddToClassList(string className) { if (!classes.Contains(className)) classes.Add(className); }
        public void RemoveFromClassList(string className) => classes.Remove(className);
        public bool ClassListContains(string cls) => classes.Contains(cls);
        public void EnableInClassList(string className, bool enable) { if (enable) AddToClassList(className); else RemoveFromClassList(className); }
        public IEnumerable<string> GetClasses() => classes;

        public Action<MeshGenerationContext> generateVisualContent { get; set; }
        public void MarkDirtyRepaint() => isDirty = true;

        public virtual bool ContainsPoint(Vector2 localPoint) => localPoint.x >= 0 && localPoint.y >= 0 && localPoint.x < layout.width && localPoint.y < layout.height;
        public override void SendEvent(EventBase e) { ownPanel?.Send(e, this); }
        public override void Focus() => ownPanel?.Focus(canGrabFocus ? this : null);
        public override void Blur() { if (ownPanel != null && ownPanel.focusController.focusedElement == this) ownPanel.Focus(null); }

        internal string Path => (physicalParent == null ? "" : physicalParent.Path + "/") + (name != "" ? name : GetType().Name);
    }

    public static class VisualElementExtensions
    {
        public static Vector2 WorldToLocal(this VisualElement ele, Vector2 p) => p - ele.worldBound.position;
        public static Vector2 LocalToWorld(this VisualElement ele, Vector2 p) => p + ele.worldBound.position;
        public static Rect LocalToWorld(this VisualElement ele, Rect r) => new Rect(r.x + ele.worldBound.x, r.y + ele.worldBound.y, r.width, r.height);
        public static void AddManipulator(this VisualElement ele, IManipulator manipulator) { if (manipulator != null) manipulator.target = ele; }
        public static void StretchToParentSize(this VisualElement elem)
        {
            elem.style.position = Position.Absolute;
            elem.style.left = elem.style.top = elem.style.right = elem.style.bottom = 0;
        }
    }

    public interface IManipulator { VisualElement target { get; set; } }

    public static class PointerCaptureHelper
    {
        public static bool HasPointerCapture(this IEventHandler handler, int pointerId) => (handler as VisualElement)?.ownPanel?.captor == handler;
        public static void CapturePointer(this IEventHandler handler, int pointerId) => (handler as VisualElement)?.ownPanel?.Capture((VisualElement)handler, pointerId);
        public static void ReleasePointer(this IEventHandler handler, int pointerId)
        {
            if (handler.HasPointerCapture(pointerId)) ((VisualElement)handler).ownPanel.Capture(null, pointerId);
        }
    }

    public struct UQueryBuilder<T> where T : VisualElement
    {
        readonly VisualElement root;
        readonly string name, className;
        internal UQueryBuilder(VisualElement root, string name, string className) { this.root = root; this.name = name; this.className = className; }
        static IEnumerable<VisualElement> Below(VisualElement at) => at.hierarchy.Children().SelectMany(child => new[] { child }.Concat(Below(child)));
        public List<T> ToList() => Found.ToList();
        public T First() => Found.FirstOrDefault();
        public void ForEach(Action<T> funcCall) { foreach (var one in ToList()) funcCall(one); }
        IEnumerable<T> Found
        {
            get
            {
                var (name, className) = (this.name, this.className);
                return new[] { root }.Concat(Below(root)).OfType<T>().Where(e => (name == null || e.name == name) && (className == null || e.ClassListContains(className)));
            }
        }
    }

    public static class UQueryExtensions
    {
        public static T Q<T>(this VisualElement e, string name = null, string className = null) where T : VisualElement => e.Query<T>(name, className).First();
        public static VisualElement Q(this VisualElement e, string name = null, string className = null) => e.Query<VisualElement>(name, className).First();
        public static UQueryBuilder<T> Query<T>(this VisualElement e, string name = null, string className = null) where T : VisualElement => new UQueryBuilder<T>(e, name, className);
    }

    // For UXML: Unity 6 takes the attribute, 2022.3 the factory.
    [AttributeUsage(AttributeTargets.Class, Inherited = false)]
    public class UxmlElementAttribute : Attribute
    {
        public UxmlElementAttribute() { }
        public UxmlElementAttribute(string uxmlName) { }
    }
    public abstract class BaseUxmlTraits { }
    public abstract class UxmlTraits : BaseUxmlTraits { }
    public abstract class BaseUxmlFactory<TCreatedType, TTraits> where TCreatedType : new() where TTraits : BaseUxmlTraits, new() { }
    public class UxmlFactory<TCreatedType, TTraits> : BaseUxmlFactory<TCreatedType, TTraits> where TCreatedType : VisualElement, new() where TTraits : UxmlTraits, new() { }
    public partial class VisualElement
    {
        public class UxmlFactory : UxmlFactory<VisualElement, UxmlTraits> { }
        public class UxmlTraits : UIElements.UxmlTraits { }
    }
}
